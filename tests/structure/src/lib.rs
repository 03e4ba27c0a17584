//! Tests of the structure of the code: see `tests`.
