//! Integration tests, one module a topic.

mod catalogue;
mod sampler;
mod simulate;
