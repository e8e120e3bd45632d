"""olp in a browser: one folder, served to the person who started it.

`app.py` answers the browser: it checks who asks and hands everything else to processes of their own, which are
closed in the folder and run `answers.py` with the command line of `olp/web_worker.py`; `desk.py` is what they answer
with, dropped recordings included. The page itself is `templates/serve.html` with its
script and style.
"""
