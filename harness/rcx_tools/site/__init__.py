"""Generator of `make site`: the documentation as web pages, with the playground."""
