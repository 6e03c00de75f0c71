//! The strikes of a data set: drawn from a recipe, or rows of a table whose gaps are drawn.
//!
//! Strike i depends on the seed and on i alone ([`Draws`]); body and material on ⌊i/repeat⌋ instead of i.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use clangor_core::glam::DVec3;
use clangor_core::material::Material;
use clangor_core::scene::body_description::Geometry;
use clangor_core::scene::strike_recipe::{
    Distribution, ListenerPlacement, StrikeRecipe, StrikeRoom, StrikerDescription, StruckObject,
};
use clangor_core::shape::Shape;

use super::draws::{Draws, Quantity};
use super::error::{DatasetError, RowPlace, StrikePlace};
use super::strike_table::{RowForce, StrikeRow};
use crate::stages::load::geometry_reference;

/// Most objects of a table whose files are looked for before anything is made: on a shared folder each look
/// takes time, for each job. Of the others, a missing file is reported when it is needed.
const MOST_CHECKED: usize = 10_000;
/// Draws of places until room and listener fit.
const MOST_TRIES: u32 = 1000;

/// A strike, but for a drawn point, which needs the surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DrawnStrike {
    pub(super) index: u64,
    /// Among the objects and materials of [`Strikes`].
    pub(super) body: (usize, usize),
    pub(super) point: Option<DVec3>,
    pub(super) normal: Option<DVec3>,
    pub(super) force: DrawnForce,
    pub(super) listener: DVec3,
    /// Room, and the place of the body in it \[m\].
    pub(super) room: Option<(usize, DVec3)>,
}

/// What strikes a body.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum DrawnForce {
    Ball {
        material: Material,
        radius: f64,
        speed: f64,
    },
    /// An impulse into the body, along the normal.
    Along {
        impulse: f64,
        duration: Option<f64>,
    },
    Impulse {
        impulse: DVec3,
        duration: Option<f64>,
    },
}

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct Strikes {
    pub(super) recipe: StrikeRecipe,
    pub(super) objects: Vec<StruckObject>,
    pub(super) materials: Vec<Material>,
    /// Materials of each object.
    of_object: Vec<Vec<usize>>,
    table: Option<Table>,
}

#[derive(Clone, Debug)]
struct Table {
    path: PathBuf,
    rows: Vec<StrikeRow>,
    /// What the rows name.
    named: Vec<Named>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Named {
    object: Option<usize>,
    material: Option<usize>,
    room: Option<usize>,
}

impl Strikes {
    /// Those of a recipe, with the rows of its table, if it has one.
    ///
    /// # Errors
    /// [`DatasetError::Cell`] for unknown names, [`DatasetError::MissingColumn`].
    pub(super) fn new(
        recipe: StrikeRecipe,
        table: Option<(&Path, Vec<StrikeRow>)>,
    ) -> Result<Self, DatasetError> {
        let mut strikes = Strikes {
            objects: recipe.objects.clone(),
            materials: Vec::new(),
            of_object: Vec::new(),
            table: None,
            recipe,
        };
        for object in strikes.objects.clone() {
            let own = object.materials.iter().map(|material| strikes.material(material)).collect();
            strikes.of_object.push(own);
        }
        if let Some((path, rows)) = table {
            let names = Names::of(&strikes);
            let named = strikes.resolve(path, &rows, names)?;
            strikes.table = Some(Table { path: path.into(), rows, named });
        }
        Ok(strikes)
    }

    /// Number of strikes.
    pub(super) fn count(&self) -> u64 {
        let rows = self.table.as_ref().map(|table| table.rows.len() as u64);
        rows.or(self.recipe.count).unwrap_or(0)
    }

    /// The place of a material among all, which has it from now on.
    fn material(&mut self, material: &Material) -> usize {
        let found = self.materials.iter().position(|known| known.name == material.name);
        found.unwrap_or_else(|| {
            self.materials.push(material.clone());
            self.materials.len() - 1
        })
    }

    /// What the rows name.
    fn resolve(
        &mut self,
        path: &Path,
        rows: &[StrikeRow],
        mut names: Names,
    ) -> Result<Vec<Named>, DatasetError> {
        let mut all = Vec::with_capacity(rows.len());
        for row in rows {
            let wrong = |column: &str, fault: String| {
                let row = RowPlace { path: path.into(), row: row.row };
                DatasetError::Cell { row, column: column.into(), fault }
            };
            let gap = |column, section| DatasetError::MissingColumn { path: path.into(), column, section };
            let mut named = Named::default();
            match &row.object {
                Some(word) => {
                    named.object = Some(
                        names
                            .object(self, path, (word, row.scale))
                            .map_err(|fault| wrong("object", fault))?,
                    )
                }
                None if self.recipe.objects.is_empty() => return Err(gap("object", "[[object]]")),
                None => {}
            }
            if let Some(name) = &row.material {
                let material =
                    self.recipe.material(name).ok_or_else(|| wrong("material", self.unknown(name)))?;
                named.material = Some(names.material(self, &material));
            } else if named.object.is_some_and(|object| self.of_object[object].is_empty()) {
                return Err(gap("material", "`materials` of an [[object]]"));
            }
            match &row.force {
                None if self.recipe.strikers.is_empty() => {
                    return Err(gap("striker or impulse_x", "[[striker]] or [[force]]"));
                }
                Some(RowForce::Ball { material, .. }) if self.recipe.material(material).is_none() => {
                    return Err(wrong("striker", self.unknown(material)));
                }
                _ => {}
            }
            if row.listener.is_none() && self.recipe.listeners.is_empty() {
                return Err(gap("listener_x", "[[listener]]"));
            }
            if let Some(name) = &row.room {
                let room = self.recipe.rooms.iter().position(|room| room.name == *name);
                let fault = || format!("is {name}, which is no room of the recipe");
                named.room = Some(room.ok_or_else(|| wrong("room", fault()))?);
            }
            all.push(named);
        }
        Ok(all)
    }

    fn unknown(&self, name: &str) -> String {
        let known: Vec<&str> = self.recipe.material_names().collect();
        format!("is {name}, which is no material; known: {}", known.join(", "))
    }

    /// Bodies with their materials that strikes may need, in order.
    pub(super) fn bodies(&self) -> BTreeSet<(usize, usize)> {
        let of = |object: usize| self.of_object[object].iter().map(move |material| (object, *material));
        let Some(table) = &self.table else { return (0..self.objects.len()).flat_map(of).collect() };
        let mut bodies = BTreeSet::new();
        for named in &table.named {
            match (named.object, named.material) {
                (Some(object), Some(material)) => {
                    bodies.insert((object, material));
                }
                (Some(object), None) => bodies.extend(of(object)),
                (None, Some(material)) => {
                    bodies.extend((0..self.recipe.objects.len()).map(|object| (object, material)));
                }
                (None, None) => bodies.extend((0..self.recipe.objects.len()).flat_map(of)),
            }
        }
        bodies
    }

    /// Where a strike is said; `column` of a table.
    pub(super) fn place(&self, index: u64, column: &'static str) -> StrikePlace {
        let row = |table: &Table| {
            Some(RowPlace { path: table.path.clone(), row: table.rows.get(index as usize)?.row })
        };
        match self.table.as_ref().and_then(row) {
            Some(row) => StrikePlace::Listed { row, column },
            None => StrikePlace::Drawn { index },
        }
    }

    /// Strike `index`, from 0.
    ///
    /// # Errors
    /// [`DatasetError::Index`], [`DatasetError::OutsideRoom`].
    pub(super) fn strike(&self, index: u64) -> Result<DrawnStrike, DatasetError> {
        if index >= self.count() {
            return Err(DatasetError::Index { index, count: self.count() });
        }
        let recipe = &self.recipe;
        let draws = |quantity| Draws::of(recipe.seed, index, quantity);
        let of_group = |quantity| Draws::of(recipe.seed, index / recipe.repeat, quantity);
        let listed = self.table.as_ref();
        let row = listed.map(|table| &table.rows[index as usize]);
        let named = listed.map_or(Named::default(), |table| table.named[index as usize]);
        let object = named.object.unwrap_or_else(|| of_group(Quantity::Object).choice(recipe.objects.len()));
        let own = &self.of_object[object];
        let material = named.material.unwrap_or_else(|| own[of_group(Quantity::Material).choice(own.len())]);
        let point = row.and_then(|row| row.point).or_else(|| {
            let points = &self.objects[object].points;
            (!points.is_empty()).then(|| points[draws(Quantity::Point).choice(points.len())])
        });
        let force = match row.and_then(|row| row.force.as_ref()) {
            Some(force) => self.listed_force(force),
            None => drawn_force(&recipe.strikers, draws(Quantity::Striker)),
        };
        let (listener, room) = self.places(index, row.and_then(|row| row.listener), named.room)?;
        let normal = row.and_then(|row| row.normal);
        Ok(DrawnStrike { index, body: (object, material), point, normal, force, listener, room })
    }

    fn listed_force(&self, force: &RowForce) -> DrawnForce {
        match force {
            RowForce::Ball { material, radius, speed } => DrawnForce::Ball {
                // Its name has been checked.
                material: self.recipe.material(material).unwrap_or_else(|| self.materials[0].clone()),
                radius: *radius,
                speed: *speed,
            },
            RowForce::Impulse { impulse, duration } => {
                DrawnForce::Impulse { impulse: *impulse, duration: *duration }
            }
        }
    }

    /// The listener relative to the body, and the room with the place of the body; drawn again until the room
    /// holds both.
    fn places(
        &self,
        index: u64,
        listener: Option<DVec3>,
        room: Option<usize>,
    ) -> Result<(DVec3, Option<(usize, DVec3)>), DatasetError> {
        let StrikeRecipe { seed, listeners, rooms, .. } = &self.recipe;
        let mut of_listener = Draws::of(*seed, index, Quantity::Listener);
        let mut of_room = Draws::of(*seed, index, Quantity::Room);
        let placement = listeners.get(of_listener.choice(listeners.len()));
        let chosen = of_room.choice(rooms.len());
        let mut draw_listener =
            || listener.or(placement.map(|p| position(p, &mut of_listener))).unwrap_or_default();
        let room = room.or((!rooms.is_empty()).then_some(chosen));
        let Some(chosen) = room else { return Ok((draw_listener(), None)) };
        let StrikeRoom { name, room, body } = &rooms[chosen];
        for _ in 0..MOST_TRIES {
            let place = coordinates(body, &mut of_room);
            let listener = draw_listener();
            if room.holds(place) && room.holds(place + listener) {
                return Ok((listener, Some((chosen, place))));
            }
        }
        Err(DatasetError::OutsideRoom { index, room: name.clone(), tries: MOST_TRIES })
    }
}

/// Objects and materials by name, while a table is read.
struct Names {
    objects: BTreeMap<String, usize>,
    materials: BTreeMap<String, usize>,
}

impl Names {
    fn of(strikes: &Strikes) -> Self {
        let objects = strikes.objects.iter().enumerate().map(|(at, object)| (object.name.clone(), at));
        let materials = strikes.materials.iter().enumerate().map(|(at, m)| (m.name.clone(), at));
        Names { objects: objects.collect(), materials: materials.collect() }
    }

    fn material(&mut self, strikes: &mut Strikes, material: &Material) -> usize {
        *self.materials.entry(material.name.clone()).or_insert_with(|| strikes.material(material))
    }

    /// The object that a word of a table names: one of the recipe, a shape, or a file; or why it is none.
    fn object(
        &mut self,
        strikes: &mut Strikes,
        table: &Path,
        (word, scale): (&str, Option<f64>),
    ) -> Result<usize, String> {
        let key = scale.map_or(word.to_owned(), |scale| format!("{word} × {scale}"));
        if let Some(at) = self.objects.get(&key) {
            return Ok(*at);
        }
        let mut geometry = geometry_reference(word, 1.0).geometry;
        let file = word.rsplit_once('#').map_or(word, |(file, _)| file);
        let is_file =
            Path::new(file).extension().is_some_and(|e| e == "safetensors" || e == "glb" || e == "gltf");
        if is_file {
            geometry = Geometry::File(word.into());
        }
        match &geometry {
            Geometry::Shape(shape) => {
                Shape::parse(shape)
                    .map_err(|error| format!("is {word}, no object of the recipe, file or shape: {error}"))?;
            }
            Geometry::File(_) => {
                let path = table.parent().unwrap_or(Path::new("")).join(file);
                if strikes.objects.len() < MOST_CHECKED && !path.is_file() {
                    return Err(format!("is {word}: there is no file {}", path.display()));
                }
            }
        }
        strikes.objects.push(StruckObject {
            name: word.into(),
            geometry,
            scale: scale.unwrap_or(1.0),
            materials: Vec::new(),
            points: Vec::new(),
            place: Default::default(),
        });
        strikes.of_object.push(Vec::new());
        self.objects.insert(key, strikes.objects.len() - 1);
        Ok(strikes.objects.len() - 1)
    }
}

fn drawn_force(strikers: &[StrikerDescription], mut draws: Draws) -> DrawnForce {
    match &strikers[draws.choice(strikers.len())] {
        StrikerDescription::Ball { materials, radius, speed } => {
            let (radius, speed) = (radius.quantile(draws.share()), speed.quantile(draws.share()));
            let material = materials[draws.choice(materials.len())].clone();
            DrawnForce::Ball { material, radius, speed }
        }
        StrikerDescription::Force { impulse, duration } => {
            let impulse = impulse.quantile(draws.share());
            let duration = duration.map(|duration| duration.quantile(draws.share()));
            DrawnForce::Along { impulse, duration }
        }
    }
}

fn coordinates(axes: &[Distribution; 3], draws: &mut Draws) -> DVec3 {
    DVec3::from_array(axes.map(|axis| axis.quantile(draws.share())))
}

/// A place of a listener \[m\].
fn position(placement: &ListenerPlacement, draws: &mut Draws) -> DVec3 {
    match placement {
        ListenerPlacement::Position(axes) => coordinates(axes, draws),
        ListenerPlacement::Along { direction, distance } => *direction * distance.quantile(draws.share()),
        ListenerPlacement::Around { distance, azimuth, elevation } => {
            let distance = distance.quantile(draws.share());
            let (sin, cos) = Distribution::Uniform(*azimuth).quantile(draws.share()).sin_cos();
            // Even by area: the sine of the elevation is even.
            let height = Distribution::Uniform(elevation.map(f64::sin)).quantile(draws.share());
            let across = (1.0 - height * height).max(0.0).sqrt();
            distance * DVec3::new(across * cos, height, across * sin)
        }
    }
}
