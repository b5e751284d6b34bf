//! The example in C++.
