"""`make site`: the documentation as web pages, and the playground in them."""
