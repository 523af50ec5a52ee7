"""The tools of an editor: the index of names, and the features of a language server.

The features are functions of the index and of the text in the editor. They know no server.
"""
