//! Hands the page to the browser of the machine it runs on, and nothing else to anyone.
//!
//! A [`Page`] is a table of names and contents, and that is the whole world of the [`Server`]: it opens no
//! file. It listens on the loopback addresses only, and answers only who asks for it by one of their names,
//! so that no other site can reach it by pointing a name of its own at this machine. What it sends forbids
//! frames, foreign scripts and use by other sites.

pub mod page;
pub mod server;

mod answer;

pub use page::{Page, embedded_page};
pub use server::{ServeError, Server};
