//! Materials by name. Every number and its source is in `docs/format/materials.md`.
//!
//! Restitutions are those of compact bodies: `glass` 0.97 ± 0.01 and `plastic` 0.87 ± 0.02 \[Foerster1994\],
//! `granite` 0.83 ± 0.06 \[Durda2011\], `ceramic` 0.98 as aluminium oxide on glass \[Kharaz2001\], `steel`
//! 0.95 at 0.3 m/s \[McNamaraFalcon2005\]. The others are estimates.

use super::{Damping, Material};

/// A material of the library.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Name.
    pub name: &'static str,
    /// Density ρ \[kg/m³\].
    pub density: f64,
    /// Young's modulus E \[Pa\].
    pub youngs_modulus: f64,
    /// Poisson's ratio ν \[-\].
    pub poisson_ratio: f64,
    /// Coefficient of restitution e of a contact \[-\], without the vibration of the bodies.
    pub restitution: f64,
    /// Speed of that restitution [m/s], for a viscous contact.
    pub restitution_speed: Option<f64>,
    /// Coefficient of restitution of whole bodies \[-\], with the vibration of those of everyday shapes: for
    /// impacts by the law of rigid bodies.
    pub rigid_restitution: f64,
    /// Coulomb friction coefficient μ \[-\].
    pub friction: f64,
    /// Rolling loss length \[m\].
    pub rolling_loss: f64,
    /// Loss factor η \[-\].
    pub loss_factor: f64,
    /// Tensile strength \[Pa\].
    pub tensile_strength: f64,
    /// Critical energy release rate G_c \[J/m²\].
    pub fracture_energy: f64,
    /// Where the elastic numbers come from.
    pub source: &'static str,
}

impl Preset {
    /// As a material for impacts by the law of rigid bodies, which knows no vibration.
    pub fn rigid_material(&self) -> Material {
        self.material().rigid()
    }

    /// As a material.
    pub fn material(&self) -> Material {
        Material {
            name: self.name.into(),
            density: self.density,
            youngs_modulus: self.youngs_modulus,
            poisson_ratio: self.poisson_ratio,
            restitution: self.restitution,
            restitution_speed: self.restitution_speed,
            rigid_restitution: Some(self.rigid_restitution),
            yield_strength: None,
            friction: self.friction,
            rolling_loss: self.rolling_loss,
            damping: Damping::LossFactor(self.loss_factor),
            tensile_strength: Some(self.tensile_strength),
            fracture_energy: Some(self.fracture_energy),
            source: self.source.into(),
        }
    }
}

/// `steel`: Gere and Timoshenko, structural steel.
pub const STEEL: Preset = Preset {
    name: "steel",
    density: 7850.0,
    youngs_modulus: 2.0e11,
    poisson_ratio: 0.29,
    restitution: 0.95,
    restitution_speed: Some(0.3),
    rigid_restitution: 0.9,
    friction: 0.4,
    rolling_loss: 5.0e-5,
    loss_factor: 3.0e-4,
    tensile_strength: 4.0e8,
    fracture_energy: 11000.0,
    source: "Gere and Timoshenko, structural steel",
};

/// `copper`: \[PAN\] Table 1, ball bearing, coin, key.
pub const COPPER: Preset = Preset {
    name: "copper",
    density: 8940.0,
    youngs_modulus: 1.234e11,
    poisson_ratio: 0.34,
    restitution: 0.7,
    restitution_speed: None,
    rigid_restitution: 0.7,
    friction: 0.35,
    rolling_loss: 5.0e-5,
    loss_factor: 0.002,
    tensile_strength: 2.2e8,
    fracture_energy: 26000.0,
    source: "[PAN] Table 1, ball bearing, coin, key",
};

/// `ceramic`: \[PAN\] Table 1, bowl, mug, plate.
pub const CERAMIC: Preset = Preset {
    name: "ceramic",
    density: 2700.0,
    youngs_modulus: 7.2e10,
    poisson_ratio: 0.19,
    restitution: 0.98,
    restitution_speed: None,
    rigid_restitution: 0.7,
    friction: 0.35,
    rolling_loss: 5.0e-5,
    loss_factor: 0.002,
    tensile_strength: 5.0e7,
    fracture_energy: 13.0,
    source: "[PAN] Table 1, bowl, mug, plate",
};

/// `glass`: \[PAN\] Table 1, glass pane.
pub const GLASS: Preset = Preset {
    name: "glass",
    density: 2600.0,
    youngs_modulus: 6.2e10,
    poisson_ratio: 0.2,
    restitution: 0.97,
    restitution_speed: None,
    rigid_restitution: 0.75,
    friction: 0.4,
    rolling_loss: 5.0e-5,
    loss_factor: 0.001,
    tensile_strength: 7.0e7,
    fracture_energy: 8.9,
    source: "[PAN] Table 1, glass pane",
};

/// `plastic`: \[PAN\] Table 1, dice.
pub const PLASTIC: Preset = Preset {
    name: "plastic",
    density: 1200.0,
    youngs_modulus: 2.4e9,
    poisson_ratio: 0.37,
    restitution: 0.87,
    restitution_speed: None,
    rigid_restitution: 0.6,
    friction: 0.35,
    rolling_loss: 1.0e-4,
    loss_factor: 0.03,
    tensile_strength: 7.0e7,
    fracture_energy: 1200.0,
    source: "[PAN] Table 1, dice",
};

/// `aluminium`: Gere and Timoshenko, alloy 6061-T6.
pub const ALUMINIUM: Preset = Preset {
    name: "aluminium",
    density: 2700.0,
    youngs_modulus: 7.0e10,
    poisson_ratio: 0.33,
    restitution: 0.7,
    restitution_speed: None,
    rigid_restitution: 0.7,
    friction: 0.4,
    rolling_loss: 5.0e-5,
    loss_factor: 1.0e-4,
    tensile_strength: 3.1e8,
    fracture_energy: 5600.0,
    source: "Gere and Timoshenko, alloy 6061-T6",
};

/// `brass`: Gere and Timoshenko, brass.
pub const BRASS: Preset = Preset {
    name: "brass",
    density: 8500.0,
    youngs_modulus: 1.0e11,
    poisson_ratio: 0.34,
    restitution: 0.75,
    restitution_speed: None,
    rigid_restitution: 0.75,
    friction: 0.4,
    rolling_loss: 5.0e-5,
    loss_factor: 5.0e-4,
    tensile_strength: 3.5e8,
    fracture_energy: 14000.0,
    source: "Gere and Timoshenko, brass",
};

/// `wood`: Young et al., oak along the grain.
pub const WOOD: Preset = Preset {
    name: "wood",
    density: 680.0,
    youngs_modulus: 1.24e10,
    poisson_ratio: 0.35,
    restitution: 0.5,
    restitution_speed: None,
    rigid_restitution: 0.5,
    friction: 0.4,
    rolling_loss: 2.0e-4,
    loss_factor: 0.01,
    tensile_strength: 7.8e7,
    fracture_energy: 500.0,
    source: "Young et al., oak along the grain",
};

/// `granite`: Gere and Timoshenko, granite.
pub const GRANITE: Preset = Preset {
    name: "granite",
    density: 2700.0,
    youngs_modulus: 6.0e10,
    poisson_ratio: 0.25,
    restitution: 0.83,
    restitution_speed: None,
    rigid_restitution: 0.7,
    friction: 0.5,
    rolling_loss: 1.0e-4,
    loss_factor: 0.005,
    tensile_strength: 1.0e7,
    fracture_energy: 12.0,
    source: "Gere and Timoshenko, granite",
};

/// `concrete`: Gere and Timoshenko, plain concrete.
pub const CONCRETE: Preset = Preset {
    name: "concrete",
    density: 2300.0,
    youngs_modulus: 3.0e10,
    poisson_ratio: 0.2,
    restitution: 0.5,
    restitution_speed: None,
    rigid_restitution: 0.5,
    friction: 0.6,
    rolling_loss: 2.0e-4,
    loss_factor: 0.006,
    tensile_strength: 3.0e6,
    fracture_energy: 45.0,
    source: "Gere and Timoshenko, plain concrete",
};

/// `rubber`: Gere and Timoshenko, rubber.
pub const RUBBER: Preset = Preset {
    name: "rubber",
    density: 1100.0,
    youngs_modulus: 3.0e6,
    poisson_ratio: 0.49,
    restitution: 0.7,
    restitution_speed: None,
    rigid_restitution: 0.7,
    friction: 0.9,
    rolling_loss: 0.001,
    loss_factor: 0.1,
    tensile_strength: 1.5e7,
    fracture_energy: 10000.0,
    source: "Gere and Timoshenko, rubber",
};

/// `soil`: Bowles, sand and gravel between loose and dense.
pub const SOIL: Preset = Preset {
    name: "soil",
    density: 1800.0,
    youngs_modulus: 1.0e8,
    poisson_ratio: 0.3,
    restitution: 0.2,
    restitution_speed: None,
    rigid_restitution: 0.2,
    friction: 0.6,
    rolling_loss: 0.005,
    loss_factor: 0.06,
    tensile_strength: 1.0e4,
    fracture_energy: 1.0,
    source: "Bowles, sand and gravel between loose and dense",
};

/// Every preset.
pub const PRESETS: &[Preset] =
    &[STEEL, COPPER, CERAMIC, GLASS, PLASTIC, ALUMINIUM, BRASS, WOOD, GRANITE, CONCRETE, RUBBER, SOIL];

/// Second names of presets.
///
/// `pan-steel` is what \[PAN\] Table 1 and \[HW\] Table 1 use for steel: the numbers are copper's.
pub const ALIASES: &[(&str, &str)] = &[("pan-steel", "copper"), ("aluminum", "aluminium")];

/// The preset of a name or alias; the material keeps the name that was asked for.
pub fn preset(name: &str) -> Option<Material> {
    Some(Material { name: name.to_owned(), ..of_name(name)?.material() })
}

/// The preset of a name or alias for impacts by the law of rigid bodies: [`Preset::rigid_material`].
pub fn rigid_preset(name: &str) -> Option<Material> {
    Some(Material { name: name.to_owned(), ..of_name(name)?.rigid_material() })
}

fn of_name(name: &str) -> Option<&'static Preset> {
    let full_name = ALIASES.iter().find(|(alias, _)| *alias == name).map_or(name, |(_, full_name)| full_name);
    PRESETS.iter().find(|p| p.name == full_name)
}

/// Names of all presets, then the aliases.
pub fn names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|p| p.name).chain(ALIASES.iter().map(|(alias, _)| *alias))
}
