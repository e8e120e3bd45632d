"""What an editor asks of a program: findings, times beside the lines, meanings of words. Knows of no editor.

Lines and columns count from 1, columns in characters, as everywhere in olp.
"""
