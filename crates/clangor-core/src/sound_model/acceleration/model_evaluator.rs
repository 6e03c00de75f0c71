//! Acceleration models ready for evaluation: the model of one body, or the bank of ellipsoids.

use std::sync::Arc;

use crate::sound_model::acceleration::field_evaluator::{FieldError, FieldEvaluator};
use crate::sound_model::acceleration::model::AccelerationModel;
use crate::sound_model::acceleration::near_field::NearField;
use crate::sound_model::soundbank::ellipsoid_bank::{EllipsoidBank, Proxy};

/// An [`AccelerationModel`] ready for evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelEvaluator {
    /// Bounding radius R \[m\] about the centre of mass.
    pub radius: f64,
    /// The field outside the bounding sphere.
    pub field: Arc<FieldEvaluator>,
    /// The field inside it.
    pub near: Option<Arc<NearField>>,
}

impl ModelEvaluator {
    /// Validates a model and computes its layout.
    ///
    /// # Errors
    /// [`FieldError`] for an inconsistent model, or numbers that are not finite.
    pub fn try_new(model: &AccelerationModel) -> Result<Self, FieldError> {
        let radius = model.radius;
        if !(radius > 0.0 && radius.is_finite()) {
            return Err(FieldError::Number { what: "the radius", value: radius });
        }
        let field = Arc::new(FieldEvaluator::try_new(&model.field)?);
        if let Some(near) = &model.near {
            near.check(field.nodes().len())?;
        }
        Ok(ModelEvaluator { radius, field, near: model.near.clone().map(Arc::new) })
    }
}

/// An [`EllipsoidBank`] ready for evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct BankEvaluator {
    bank: EllipsoidBank,
    fields: Vec<Arc<FieldEvaluator>>,
}

impl BankEvaluator {
    /// Validates the fields of a bank and computes their layout.
    ///
    /// # Errors
    /// [`FieldError`] for an inconsistent field, or numbers that are not finite.
    pub fn try_new(bank: EllipsoidBank) -> Result<Self, FieldError> {
        let lay_out = |entry: &crate::sound_model::soundbank::ellipsoid_bank::BankEntry| {
            FieldEvaluator::try_new(&entry.field).map(Arc::new)
        };
        let fields = bank.entries().iter().map(lay_out).collect::<Result<_, _>>()?;
        Ok(BankEvaluator { bank, fields })
    }

    /// The bank, which selects the ellipsoid for a body.
    pub fn bank(&self) -> &EllipsoidBank {
        &self.bank
    }

    /// The field of the ellipsoid of this bank that is nearest to a proxy.
    pub fn field(&self, proxy: &Proxy) -> &Arc<FieldEvaluator> {
        &self.fields[proxy.entry]
    }
}
