"""The protocol: lists the tools, and gives each call to a worker that can be ended. Nothing is known here about robots.

Codes: Z005 out of time, Z006 no such tool, Z007 the server only reads, Z008 unexpected.
"""

from __future__ import annotations

import asyncio
import json
import logging
import os
import tempfile
from pathlib import Path
from typing import Any

import mcp_types as types
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server
from pydantic import ValidationError

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.version import __version__
from olp.servers.confinement import end_worker, start_worker
from olp.servers.folder import ServerLimits
from olp.servers.mcp.tool import AssistantTool, ToolArguments, load_tool, tool_names

log = logging.getLogger("olp.mcp")
_AT_ONCE = 2  # workers
_INSTRUCTIONS = """\
olp predicts how long industrial robot programs take, line by line, and why; it judges, compares, translates and \
explains them. Paths are relative to one folder. Times are in s, lengths in mm, speeds in mm/s. Everything that a \
program does not say is listed as assumed: tell the user. Robots move by programs: never present a translation without \
its losses."""


class FolderService:
    """Serves the tools for one folder. `root`: its absolute path without symbolic links. `write`: whether tools may
    write.
    """

    def __init__(self, root: Path, write: bool = False, limits: ServerLimits | None = None) -> None:
        self.root = root
        self.write = write
        self.limits = limits or ServerLimits()
        self.places = asyncio.Semaphore(_AT_ONCE)

    def tools(self) -> list[AssistantTool[Any]]:
        """Return the tools that this server offers: those that write only with `write`."""
        found = map(load_tool, tool_names())
        return [tool for tool in found if self.write or not tool.writes]

    async def list_tools(self, context: object, asked: object) -> types.ListToolsResult:
        """Answer the protocol's request `tools/list`."""
        return types.ListToolsResult(tools=[self.described(tool) for tool in self.tools()])

    def described(self, tool: AssistantTool[Any]) -> types.Tool:
        """Return a tool's description in the protocol's form, with the JSON schemas of its arguments and answer."""
        name = type(tool).__module__.rpartition(".")[2]
        reads = not tool.writes and not (self.write and "output" in tool.given.model_fields)
        return types.Tool(
            name=name,
            title=tool.title,
            description=tool.description,
            input_schema=tool.given.model_json_schema(),
            output_schema=tool.answer.model_json_schema(),
            annotations=types.ToolAnnotations(
                title=tool.title,
                read_only_hint=reads,
                destructive_hint=not reads,
                idempotent_hint=True,
                open_world_hint=False,
            ),
        )

    async def call_tool(self, context: object, asked: types.CallToolRequestParams) -> types.CallToolResult:
        """Answer the protocol's request `tools/call`. Never raises: every error becomes part of the result."""
        try:
            tool = load_tool(asked.name[:100])
            if tool.writes and not self.write:
                help = "have the user start olp mcp with --write"
                raise OlpError(error("Z007", f"{asked.name} writes, and this server only reads", help=help))
            told = await self.worked(asked.name, check(tool, asked.arguments))
        except OlpError as refused:
            return refusal(refused.diagnostics)
        except Exception as problem:
            log.exception("a call of %r failed", asked.name[:100])
            says = f"olp failed in a way that it does not know ({type(problem).__name__})"
            return refusal([error("Z008", says, help="the server's log has the details")])
        text = json.dumps(told, ensure_ascii=False)
        content: list[types.ContentBlock] = [types.TextContent(type="text", text=text)]
        return types.CallToolResult(
            content=content, structured_content=told, is_error=told.get("exit_status") == 2
        )

    async def worked(self, name: str, arguments: dict[str, Any]) -> dict[str, Any]:
        """Run a tool in a worker process and return its answer. Raises OlpError: what the worker rejects, and Z005
        at the time limit.
        """
        async with self.places:
            with tempfile.TemporaryDirectory(prefix="olp-mcp-", ignore_cleanup_errors=True) as temporary:
                request = {
                    "tool": name,
                    "arguments": arguments,
                    "root": str(self.root),
                    "temporary": os.path.realpath(temporary),
                    "write": self.write,
                    "limits": self.limits.as_json(),
                }
                printed = await self._ran(json.dumps(request).encode())
        try:
            told = json.loads(printed)
        except ValueError:
            says = "this call ended without an answer: too much memory, or too long"
            raise OlpError(error("Z005", says, help="ask about fewer or smaller programs")) from None
        if "diagnostics" in told:
            raise OlpError(*(_diagnostic(row) for row in told["diagnostics"]))
        answer: dict[str, Any] = told["answer"]
        return answer

    async def _ran(self, request: bytes) -> bytes:
        worker = await start_worker("assistant_worker.py")
        try:
            printed, _ = await asyncio.wait_for(worker.communicate(request), self.limits.seconds)
        except TimeoutError:
            says = f"no answer after {self.limits.seconds:g} s"
            help = "ask about fewer or smaller programs, or fewer max_steps"
            raise OlpError(error("Z005", says, help=help)) from None
        finally:
            await end_worker(worker)
        return printed


def _diagnostic(row: dict[str, Any]) -> Diagnostic:
    return error(row["code"], row["message"], file=row["file"], help=row["help"])


def refusal(diagnostics: tuple[Diagnostic, ...] | list[Diagnostic]) -> types.CallToolResult:
    """Return an error result that shows at most 50 diagnostics."""
    text = "\n\n".join(diagnostic.render() for diagnostic in diagnostics[:50])
    return types.CallToolResult(content=[types.TextContent(type="text", text=text)], is_error=True)


async def serve(service: FolderService) -> None:
    """Serve the protocol over standard input and output until the client closes the connection."""
    server: Server[Any] = Server(
        "olp",
        version=__version__,
        title="olp",
        instructions=_INSTRUCTIONS,
        on_list_tools=service.list_tools,
        on_call_tool=service.call_tool,
    )
    async with stdio_server() as (reads, writes):
        await server.run(reads, writes, server.create_initialization_options())


# --- Arguments ---
# Checks what an assistant sends, before anything is started for it. Code: Z006 wrong arguments.

_KINDS = {
    "string_type": "a text",
    "list_type": "a list",
    "bool_type": "true or false",
    "int_type": "a whole number",
}
_KINDS |= {"float_type": "a number"}


def check(tool: AssistantTool[Any], arguments: dict[str, Any] | None) -> dict[str, Any]:
    """Return the validated arguments, with defaults filled in. Raises OlpError (Z006) with up to 20 problems."""
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
