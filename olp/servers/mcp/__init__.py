"""olp for assistants: a server of the Model Context Protocol over stdio.

`server.py` speaks the protocol and starts a process of its own for each call: `worker.py`, with the command line of
`olp/assistant_worker.py`. That process confines itself to one folder (`folder.py`), runs the command line as a person
would, and can be ended at any time. What can be asked stands in `tools/`, one tool per file.
"""
