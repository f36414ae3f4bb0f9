//! Problems with known evidence.
