"""olp in a browser: one folder, served to the person who started it.

`app.py` answers the browser: it checks who asks and hands everything else to processes of their own (`pool.py`), which
are closed in the folder and run `worker.py` with the command line of `olp/web_worker.py`. What they answer stands in
`answers.py`, what they make of dropped recordings in `dropped.py`. The page itself is `templates/serve.html` with its
script and style.
"""
