"""The target: the adapter, its objects, connections and servers."""
