//! Names of the files in the folder of a timeline.

pub(super) const DESCRIPTION_FILE: &str = "timeline.json";
pub(super) const CONTACTS_FILE: &str = "contacts.parquet";
pub(super) const POSES_FILE: &str = "poses.parquet";
pub(super) const FRACTURES_FILE: &str = "fractures.parquet";
pub(super) const FORCES_FILE: &str = "forces.parquet";
pub(super) const SAMPLES_FILE: &str = "force_samples.parquet";
pub(super) const MESH_FOLDER: &str = "meshes";
