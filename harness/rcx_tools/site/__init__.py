"""Generator of `make site`: the documentation as web pages, including the playground."""
