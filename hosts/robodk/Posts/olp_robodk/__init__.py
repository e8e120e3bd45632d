"""What the posts of this folder share: `calls.py` takes down what RoboDK says, `post.py` writes it with olp."""
