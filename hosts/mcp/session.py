"""A client as assistants have it: takes each configuration of README.md, starts the server that it names, and asks."""

from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path
from typing import Any

import anyio
from mcp import ClientSession, StdioServerParameters, stdio_client

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
README = (HERE / "README.md").read_text(encoding="utf-8")
FOLDER = str(ROOT / "samples" / "inform")
JOB = "generations/dx200.jbi"


def configurations() -> list[dict[str, Any]]:
    """The entries `olp` of all configurations, for the samples' folder."""
    found = []
    for text in re.findall(r"```json\n(.*?)```", README, re.S):
        (servers,) = json.loads(text).values()
        for name in ("/home/me/robots", "${workspaceFolder}"):
            servers["olp"]["args"] = [FOLDER if word == name else word for word in servers["olp"]["args"]]
        found.append(servers["olp"])
    return found


async def ask(session: ClientSession) -> list[str]:
    """The lines of the run that README.md shows."""
    told = await session.initialize()
    tools = sorted(tool.name for tool in (await session.list_tools()).tools)
    rows = [f"{told.server_info.name}: {' '.join(tools)}"]
    answer = (await session.call_tool("time", {"jobs": [JOB]})).structured_content
    (program,) = answer["programs"]
    longest = max(program["segments"], key=lambda row: row["duration_s"])
    rows.append(
        f"time: {program['file']} {program['total_s']:.3f} s, of it {program['motion_s']:.3f} s motion; longest: "
        f"line {longest['line']}, {longest['duration_s']:.3f} s, limited by {longest['limited_by']}"
    )
    why = await session.call_tool("explain", {"job": JOB, "line": longest["line"]})
    rows.append(f"explain: {why.structured_content['text'].splitlines()[0]}")
    refused = await session.call_tool("time", {"jobs": ["/etc/passwd"]})
    assert refused.is_error
    rows.append(f"refused: {refused.content[0].text.splitlines()[0]}")
    return rows


async def run(command: str, arguments: list[str]) -> list[str]:
    """One session with the server of this command line."""
    server = StdioServerParameters(command=command, args=arguments, env={"PYTHONPATH": str(ROOT)}, cwd="/")
    async with stdio_client(server) as streams, ClientSession(*streams) as session:
        return await ask(session)


def main() -> int:
    shown = re.findall(r"```text\n(.*?)```", README, re.S)[0].splitlines()
    entries = configurations()
    assert len(entries) == 2, "README.md has lost a configuration"
    for entry in entries:
        assert entry["command"] == "olp"
        # An installed olp is this file; here it is the one of the checkout.
        rows = anyio.run(run, os.environ.get("OLP_PYTHON", sys.executable), ["-m", "olp", *entry["args"]])
        print("\n".join(rows))
        if rows != shown:
            print("README.md shows another run:", *shown, sep="\n", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
