"""The process of one call of `olp mcp`, started by its path: olp/servers/mcp/worker.py with the command line."""

from olp.__main__ import dispatch
from olp.servers.mcp.worker import main

if __name__ == "__main__":
    main(dispatch)
