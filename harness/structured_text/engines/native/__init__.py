"""What engines share that run a shared object: compiling it, its memory, its scans."""
