"""Checks what an assistant sends, before anything is started for it. Code: Z006 wrong arguments."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.servers.mcp.tool import AssistantTool, ToolArguments

_KINDS = {
    "string_type": "a text",
    "list_type": "a list",
    "bool_type": "true or false",
    "int_type": "a whole number",
}
_KINDS |= {"float_type": "a number"}


def check(tool: AssistantTool[Any], arguments: dict[str, Any] | None) -> dict[str, Any]:
    """The arguments with their defaults. Raises OlpError (Z006) with everything that is wrong."""
    try:
        return tool.given.model_validate(arguments or {}).model_dump()
    except ValidationError as refused:
        found = refused.errors(include_url=False, include_context=False)
        raise OlpError(*(_problem(one, tool.given) for one in found[:20])) from None


def _problem(found: Any, given: type[ToolArguments]) -> Diagnostic:
    place = ".".join(str(part) for part in found["loc"])[:100]
    known = given.model_fields
    if found["type"] == "extra_forbidden":
        return error("Z006", f"there is no argument {place!r}", help=f"there are: {', '.join(known)}")
    field = known.get(str(found["loc"][0])) if found["loc"] else None
    help = f"{found['loc'][0]}: {field.description}" if field is not None else ""
    if found["type"] == "missing":
        return error("Z006", f"the argument {place!r} is missing", help=help)
    wanted = _KINDS.get(found["type"])
    says = f"must be {wanted}" if wanted else str(found["msg"])[:200]
    return error("Z006", f"{place}: {says}, not {_shown(found['input'])}", help=help)


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}…"
