"""olp for assistants: a server of the Model Context Protocol over stdio.

`server.py` speaks the protocol and starts, for each call, a process of its own: `worker.py`, with the
command line of `olp/assistant_worker.py`. That confines itself to
one folder (`guard.py`), runs the command line as a person would, and can be ended at any time. What can be asked stands
in `tools/`, one tool per file.
"""
