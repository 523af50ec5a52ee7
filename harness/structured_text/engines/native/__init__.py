"""The common part of engines that run a shared object: its compilation, memory and scans."""
