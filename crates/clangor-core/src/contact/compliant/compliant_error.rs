//! Errors in the data of an impact between bodies that give way.

/// Error in the members, contacts or settings of an impact.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompliantContactError {
    /// More contacts than one system may have: its matrices are dense.
    #[error("the impact has {count} contacts; at most {limit} can be solved at once")]
    TooManyContacts {
        /// Number of contacts.
        count: usize,
        /// Most contacts.
        limit: usize,
    },
    /// No contact at all.
    #[error("the impact has no contact")]
    NoContacts,
    /// A contact names an unknown member.
    #[error("contact {contact} names member {member}, but there are {members}")]
    UnknownMember {
        /// Index of the contact.
        contact: usize,
        /// Index of the member.
        member: usize,
        /// Number of members.
        members: usize,
    },
    /// A contact of a member with itself, or of two immovable bodies.
    #[error("contact {contact} does not join two different bodies of which one can move")]
    NotAPair {
        /// Index of the contact.
        contact: usize,
    },
    /// A quantity of a member that is not finite or out of range.
    #[error("the {what} of member {member} is {value}, but must be {wanted}")]
    Member {
        /// Index of the member.
        member: usize,
        /// Quantity.
        what: &'static str,
        /// Its value, or the component that is out of range.
        value: f64,
        /// What is allowed.
        wanted: &'static str,
    },
    /// A mode of a member that is not finite, grows, or does not oscillate.
    #[error("mode {mode} of member {member} has the pole {re} + {im}i 1/s, but Re ≤ 0 and Im > 0 are needed")]
    Pole {
        /// Index of the member.
        member: usize,
        /// Index of the mode.
        mode: usize,
        /// Real part [1/s].
        re: f64,
        /// Imaginary part [1/s].
        im: f64,
    },
    /// As many states or shapes as modes are needed.
    #[error("member {member} has {modes} modes, but {count} {what}")]
    Lengths {
        /// Index of the member.
        member: usize,
        /// Number of modes.
        modes: usize,
        /// Number of what was given.
        count: usize,
        /// What was given.
        what: &'static str,
    },
    /// A quantity of a contact that is not finite or out of range.
    #[error("the {what} of contact {contact} is {value}, but must be {wanted}")]
    Contact {
        /// Index of the contact.
        contact: usize,
        /// Quantity.
        what: &'static str,
        /// Its value, or the component that is out of range.
        value: f64,
        /// What is allowed.
        wanted: &'static str,
    },
    /// A setting out of range.
    #[error("the setting {what} is {value}, but must be positive and finite")]
    Settings {
        /// Name of the setting.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// Nothing touches or approaches, so that no step follows from the impact.
    #[error("no contact touches or approaches; give a step")]
    NoDuration,
    /// A force that is not finite: numbers beyond what `f64` holds.
    #[error("the force of the impact is not finite in step {step} of {seconds} s")]
    NotFinite {
        /// Index of the step.
        step: usize,
        /// Length of the step \[s\].
        seconds: f64,
    },
}
