//! Settings of modal sound: transfer from modes to pressure, and damping.

/// Orders of the transfers that are evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TransferOrder {
    /// All orders of the model.
    #[default]
    Baked,
    /// As in a paper.
    Reference,
}

/// Transfer from a vibrating mode to pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModalPressure {
    /// Re{H A}: the complex transfer of the modal acceleration.
    #[default]
    Acceleration,
    /// As in a paper.
    Reference,
}

/// Settings of the modal sound of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModalSettings {
    /// Transfer from modes to pressure.
    pub pressure: ModalPressure,
    /// Orders of the transfers that are evaluated.
    pub orders: TransferOrder,
    /// Whether radiation adds to the damping of the material.
    pub radiation_damping: bool,
    /// c [N s/m]: a contact point adds c (n·U)² to 2ξω of each mode; 0 for no contact damping.
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
