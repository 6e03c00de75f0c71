//! How much work a bake may be.

/// The effort of a bake; its options say the accuracy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// As much as the accuracy needs.
    #[default]
    Exact,
    /// A few seconds for any body: fields and transfers by a few hundred unknowns, about a hundred modes on a
    /// coarse mesh. Its errors are reported, not bounded.
    Draft,
}
