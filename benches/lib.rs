//! What the project measures of itself; each bench is a program of its own.
