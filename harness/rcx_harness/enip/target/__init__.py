"""The target of connections: the adapter with its objects, connections and servers."""
