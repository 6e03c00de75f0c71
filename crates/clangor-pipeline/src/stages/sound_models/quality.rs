//! How good baked models must be, in one word.

/// Effort for the sound models of bodies: their errors, unless
/// [`ModelOptions::accuracy`](super::ModelOptions::accuracy) gives one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Models within 1 % that are in the cache, and drafts: third octaves of clicks within about 3 dB in the
    /// median, about a hundred modes with the error that their evidence gives.
    Draft,
    /// Errors of 1 %.
    #[default]
    Normal,
    /// Errors of 0.2 %; frequencies of modes within 0.5 %.
    High,
}

impl Quality {
    /// Error of a field, relative to the loudest motion of the body \[-\].
    pub(super) fn field_error(self) -> f64 {
        if self == Quality::High { 0.002 } else { 0.01 }
    }

    /// Relative error of the frequency of a mode by its mesh \[-\].
    pub(super) fn mesh_error(self) -> f64 {
        if self == Quality::High { 0.005 } else { 0.01 }
    }

    /// Level error of the transfer of a mode \[-\].
    pub(super) fn transfer_error(self) -> f64 {
        if self == Quality::High { 0.002 } else { 0.01 }
    }
}
