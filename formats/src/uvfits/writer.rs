//! Writing.
/// Stub.
#[derive(Debug)]
pub struct UvfitsWriter;
