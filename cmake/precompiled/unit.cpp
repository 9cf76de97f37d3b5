// The unit that a precompiled header is compiled with has nothing of its own.
