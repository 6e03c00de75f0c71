//! Closed forms: what is computed equals them.

#[path = "../falling_balls/mod.rs"]
mod falling_balls;
#[expect(unused, reason = "parts of it are for other tests")]
#[path = "../imported_motion/mod.rs"]
mod imported_motion;
#[expect(dead_code, reason = "parts of it are for other tests")]
#[path = "../parquet_columns/mod.rs"]
mod parquet_columns;

mod bodies_between;
mod first_and_last_frames;
mod ground_render;
mod held_bodies;
mod joined_bodies;
mod led_bodies;
mod listed_flights;
mod motion_impacts;
mod passed_on;
mod piles;
mod plate_impacts;
mod scene_supports;
mod thin_panes;
