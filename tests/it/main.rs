//! Integration tests, one module a topic.

mod simulate;
mod catalogue;
mod sampler;
