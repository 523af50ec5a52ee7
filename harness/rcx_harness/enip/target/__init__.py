"""What answers: the adapter, its objects, connections and servers."""
