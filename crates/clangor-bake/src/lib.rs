//! Offline numerics: the sound models of a body of any shape, from its rigid acceleration and from its modes.
//!
//! ```text
//! acceleration: shape ─► RadiationSolver ─► multipoles at some k ─► rational fit ─► AccelerationField
//! modal:        shape ─► modal analysis ─► modes ─► radiation of each mode ─► ModalModel
//! ```
//!
//! | module | computes |
//! |---|---|
//! | [`acceleration`], [`modal`] | the two models of a body: choice of the solvers, fit, evidence |
//! | [`cost`], [`effort`] | how much work a bake is, and may be |
//! | [`geometry_class`] | class and symmetries of a geometry |
//! | [`mesh`] | triangles of a surface, tetrahedra of a volume |
//! | [`fem`], [`modal_analysis`] | stiffness and mass; modes and frequencies |
//! | [`bem`], [`fdtd`] | solvers of the exterior acoustic problem, in frequency and in time |
//! | [`modal_radiation`] | transfers of modes, by each of these solvers |
//! | [`fitting`] | multipoles, rational functions, comparison of fields |
//! | [`soundbank`] | models of ellipsoids that stand in for other bodies |
//! | [`stress`] | quasi-static stress under contact forces, for fracture |
//! | [`reference`](mod@reference) | the representations that \[PAN\] and \[PROXY\] published |
//!
//! Computations here may be slow, multithreaded and memory-intensive. The results are the types of
//! `clangor_core::sound_model`, which the runtime library evaluates.

pub mod acceleration;
pub mod bem;
pub mod cost;
pub mod effort;
pub mod fdtd;
pub mod fem;
pub mod fitting;
pub mod geometry_class;
pub mod gpu;
pub mod mesh;
pub mod modal;
pub mod modal_analysis;
pub mod modal_radiation;
pub mod quadrature;
pub mod radiation;
pub mod reference;
pub mod soundbank;
pub mod statistical;
pub mod stress;
