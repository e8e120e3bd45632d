"""A process of `olp serve`, started by its path: olp/servers/web/answers.py with the command line."""

from olp.__main__ import dispatch
from olp.servers.web.answers import main

if __name__ == "__main__":
    main(dispatch)
