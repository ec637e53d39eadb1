//! Why a request of a person is refused.

use std::fmt;

/// Why a request is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Refusal {
    pub kind: RefusalKind,
    /// The field of the form that is wrong.
    pub field: Option<&'static str>,
    /// In words, for the person.
    pub cause: String,
}

/// Who has to act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum RefusalKind {
    /// The person: something entered is wrong.
    Wrong,
    /// Not possible in the current state, whoever asks.
    NotNow,
}

impl Refusal {
    pub(crate) fn wrong(field: &'static str, cause: impl fmt::Display) -> Self {
        Self {
            kind: RefusalKind::Wrong,
            field: Some(field),
            cause: cause.to_string(),
        }
    }

    pub(crate) fn not_now(cause: impl fmt::Display) -> Self {
        Self {
            kind: RefusalKind::NotNow,
            field: None,
            cause: cause.to_string(),
        }
    }
}
