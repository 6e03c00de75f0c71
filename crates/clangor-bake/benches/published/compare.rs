//! Published against ours on the same bodies: errors, bytes, time.

/// Prints the table.
pub(crate) fn print() {}
