//! Why a picture cannot be used.

/// The largest picture that a detector takes, with three colours; a malicious one asks for more.
pub(super) const MAX_BYTES: usize = 3 << 27;

/// What is wrong, and what to do.
#[derive(Debug)]
pub(super) struct Flaw {
    pub(super) cause: String,
    pub(super) remedy: &'static str,
}

impl Flaw {
    pub(super) fn new(cause: impl Into<String>, remedy: &'static str) -> Self {
        let cause = cause.into();
        Self { cause, remedy }
    }

    pub(super) fn truncated() -> Self {
        Self::new("the picture is truncated", "copy or record it again")
    }

    pub(super) fn too_large(bytes: usize) -> Self {
        let cause = format!("a picture of more than {} MB", bytes >> 20);
        Self::new(cause, "make it smaller")
    }

    pub(super) fn damaged(name: &str, error: impl std::fmt::Display) -> Self {
        let cause = format!("the {name} is damaged: {error}");
        Self::new(cause, "copy or record it again")
    }
}
