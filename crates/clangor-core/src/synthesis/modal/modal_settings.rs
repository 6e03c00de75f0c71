//! Settings of modal sound: how modes become pressure, and what damps them.

/// How many orders of a transfer are played.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TransferOrder {
    /// All that were baked.
    #[default]
    Baked,
    /// As a paper has it.
    Reference,
}

/// How a vibrating mode becomes pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModalPressure {
    /// Re{H A}: the complex transfer of the modal acceleration.
    #[default]
    Acceleration,
    /// As a paper has it.
    Reference,
}

/// How bodies ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModalSettings {
    /// How modes become pressure.
    pub pressure: ModalPressure,
    /// Orders of the transfers that are played.
    pub orders: TransferOrder,
    /// Whether what a mode radiates damps it, on top of its material.
    pub radiation_damping: bool,
    /// c [N s/m]: a touching point adds c (n·U)² to 2ξω of each mode; 0 for none.
    pub contact_damping: f64,
}

impl Default for ModalSettings {
    fn default() -> Self {
        ModalSettings {
            pressure: ModalPressure::default(),
            orders: TransferOrder::default(),
            radiation_damping: true,
            contact_damping: 0.0,
        }
    }
}
