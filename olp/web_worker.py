"""A process of `olp serve`, started by its path: olp/servers/web/worker.py with the command line."""

from olp.__main__ import dispatch
from olp.servers.web.worker import main

if __name__ == "__main__":
    main(dispatch)
