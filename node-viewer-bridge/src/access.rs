//! Access to the page: free on its own machine, by token elsewhere.
//!
//! A token arrives as the cookie set by `POST /api/session`, which is hidden from scripts and from requests of other
//! pages, or as `Authorization: Bearer TOKEN` from other programs. Tokens are compared in constant time, and an address
//! with too many wrong tokens has to wait.

use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use axum::http::{HeaderMap, HeaderValue, header};
use serde::{Deserialize, Serialize};
use sextant_site_files::{Complaint, FileError, read_toml_checked};
use sextant_site_model::CameraId;
use subtle::{Choice, ConstantTimeEq};

/// Permissions on the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum PageRole {
    /// Is a camera, and sees nothing.
    Camera,
    /// Views everything.
    Viewer,
    /// Also uses the wizards, applies refinements and reverts changes.
    Operator,
}

/// The cookie that carries a token.
const COOKIE: &str = "sextant_token";
/// Lifetime of the cookie in seconds: a month.
const COOKIE_AGE_S: u32 = 30 * 86_400;
/// Least length of a token; shorter ones can be guessed.
const MIN_TOKEN_BYTES: usize = 16;
/// Wrong tokens per address in [`TRIES_PERIOD`] before it has to wait.
const MOST_TRIES: u32 = 10;
const TRIES_PERIOD: Duration = Duration::from_secs(60);
/// Most addresses with wrong tokens that are remembered; when full, further addresses have to wait.
const MOST_ADDRESSES: usize = 1024;

/// `page-tokens.toml`. Has no `Debug`, so that it cannot be logged.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Tokens {
    read: String,
    operate: String,
    /// Of browsers that are cameras, by the camera's name; in a file of their own.
    #[serde(skip)]
    cameras: BTreeMap<CameraId, String>,
}

impl Tokens {
    /// Reads the file.
    ///
    /// # Errors
    /// A missing or malformed file, or tokens that can be guessed.
    pub(crate) fn read(file: &Path) -> Result<Self, FileError> {
        read_toml_checked(file, |tokens: &Self| {
            check(&tokens.read, "read")?;
            check(&tokens.operate, "operate")?;
            if tokens.read == tokens.operate {
                let cause = "is the token of readers, too".to_owned();
                return Err(Complaint::new("operate", cause, "choose another one"));
            }
            Ok(())
        })
    }

    /// With those of browsers that are cameras.
    ///
    /// # Errors
    /// A malformed file, or tokens that can be guessed; a missing file has none.
    pub(crate) fn with_phones(mut self, file: &Path) -> Result<Self, FileError> {
        if file.exists() {
            self.cameras = read_toml_checked(file, |cameras: &BTreeMap<CameraId, String>| {
                let mut tokens = cameras.iter();
                tokens.try_for_each(|(camera, token)| check(token, camera.as_str()))
            })?;
        }
        Ok(self)
    }

    fn role_of(&self, token: &str) -> Option<PageRole> {
        let is = |other: &str| -> Choice { token.as_bytes().ct_eq(other.as_bytes()) };
        let (operates, reads) = (is(&self.operate), is(&self.read));
        if operates.into() {
            Some(PageRole::Operator)
        } else if reads.into() {
            Some(PageRole::Viewer)
        } else {
            self.camera_of(token).map(|_| PageRole::Camera)
        }
    }

    /// The camera whose token this is. Compares with all of them.
    fn camera_of(&self, token: &str) -> Option<&CameraId> {
        let mut found = None;
        for (camera, own) in &self.cameras {
            if bool::from(token.as_bytes().ct_eq(own.as_bytes())) {
                found = Some(camera);
            }
        }
        found
    }
}

fn check(token: &str, key: &str) -> Result<(), Complaint> {
    if token.len() >= MIN_TOKEN_BYTES && token.bytes().all(|b| b.is_ascii_alphanumeric()) {
        return Ok(());
    }
    Err(Complaint::new(
        key,
        format!("a token is at least {MIN_TOKEN_BYTES} letters and digits"),
        "`sextant keys add` creates random tokens",
    ))
}

/// Why a request is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Denied {
    /// Its token is missing or wrong.
    NoToken,
    /// Its token is not that of the camera that it wants to be.
    NotThisCamera,
    /// Too many wrong tokens from its address.
    TooManyTries,
}

/// The access rule of a bridge.
pub(crate) struct PageAccess {
    tokens: Option<Tokens>,
    /// Permissions of the bridge itself on the site's network.
    most: PageRole,
    /// Whether browsers can connect by TLS only.
    is_secure: bool,
    tries: Mutex<Tries>,
}

impl PageAccess {
    /// Everybody who reaches the page has all permissions.
    pub(crate) fn open() -> Self {
        Self {
            tokens: None,
            most: PageRole::Operator,
            is_secure: false,
            tries: Mutex::default(),
        }
    }

    /// A token grants its permissions, at most `most`. `is_secure`: over TLS.
    pub(crate) fn by_token(tokens: Tokens, most: PageRole, is_secure: bool) -> Self {
        Self {
            tokens: Some(tokens),
            most,
            is_secure,
            ..Self::open()
        }
    }

    /// Permissions of the sender of a request.
    pub(crate) fn role_of(
        &self,
        headers: &HeaderMap,
        from: IpAddr,
        now: Instant,
    ) -> Result<PageRole, Denied> {
        if self.tokens.is_none() {
            return Ok(self.most);
        }
        let token = bearer(headers).or_else(|| cookie(headers));
        self.role_of_token(token.ok_or(Denied::NoToken)?, from, now)
    }

    /// Cameras that browsers may be and the token of each; none where any name will do without one.
    pub(crate) fn phones(&self) -> Option<&BTreeMap<CameraId, String>> {
        self.tokens.as_ref().map(|tokens| &tokens.cameras)
    }

    /// Whether the sender of a request may be this camera: its token is the camera's, or no token is needed.
    pub(crate) fn check_camera(
        &self,
        headers: &HeaderMap,
        from: IpAddr,
        camera: &CameraId,
        now: Instant,
    ) -> Result<(), Denied> {
        let Some(tokens) = &self.tokens else {
            return Ok(());
        };
        self.role_of(headers, from, now)?;
        let token = bearer(headers).or_else(|| cookie(headers));
        let is_own = token.is_some_and(|token| tokens.camera_of(token) == Some(camera));
        is_own.then_some(()).ok_or(Denied::NotThisCamera)
    }

    /// Permissions of a token's owner. A wrong token counts against the address.
    pub(crate) fn role_of_token(
        &self,
        token: &str,
        from: IpAddr,
        now: Instant,
    ) -> Result<PageRole, Denied> {
        let Some(tokens) = &self.tokens else {
            return Ok(self.most);
        };
        let mut tries = self.tries.lock().unwrap_or_else(PoisonError::into_inner);
        if !tries.may_try(from, now) {
            return Err(Denied::TooManyTries);
        }
        match tokens.role_of(token) {
            Some(role) => Ok(role.min(self.most)),
            None => {
                tries.was_wrong(from, now);
                tracing::warn!(%from, "a wrong token for the page");
                Err(Denied::NoToken)
            }
        }
    }

    /// The cookie that makes a browser send this token from now on; `None` for tokens that are not letters and digits.
    pub(crate) fn cookie_of(&self, token: &str) -> Option<HeaderValue> {
        self.set_cookie(token, COOKIE_AGE_S)
    }

    /// The cookie that makes a browser forget its token.
    pub(crate) fn no_cookie(&self) -> Option<HeaderValue> {
        self.set_cookie("", 0)
    }

    fn set_cookie(&self, token: &str, age_s: u32) -> Option<HeaderValue> {
        let secure = if self.is_secure { "; Secure" } else { "" };
        HeaderValue::from_str(&format!(
            "{COOKIE}={token}; Path=/; Max-Age={age_s}; HttpOnly; SameSite=Strict{secure}"
        ))
        .ok()
    }
}

fn bearer(headers: &HeaderMap) -> Option<&str> {
    let value = headers.get(header::AUTHORIZATION)?.to_str().ok()?;
    value.strip_prefix("Bearer ").map(str::trim)
}

fn cookie(headers: &HeaderMap) -> Option<&str> {
    let lines = headers.get_all(header::COOKIE).into_iter();
    let pairs = lines.filter_map(|line| line.to_str().ok());
    let mut pairs = pairs.flat_map(|line| line.split(';'));
    pairs.find_map(|pair| pair.trim().strip_prefix(COOKIE)?.strip_prefix('='))
}

/// Wrong tokens by address.
#[derive(Debug, Default)]
struct Tries(HashMap<IpAddr, Tried>);

#[derive(Debug)]
struct Tried {
    since: Instant,
    wrong: u32,
}

impl Tries {
    fn may_try(&mut self, from: IpAddr, now: Instant) -> bool {
        self.0
            .retain(|_, tried| now.duration_since(tried.since) < TRIES_PERIOD);
        match self.0.get(&from) {
            Some(tried) => tried.wrong < MOST_TRIES,
            None => self.0.len() < MOST_ADDRESSES,
        }
    }

    fn was_wrong(&mut self, from: IpAddr, now: Instant) {
        let new = Tried {
            since: now,
            wrong: 0,
        };
        self.0.entry(from).or_insert(new).wrong += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    const READ: &str = "readreadreadread";
    const OPERATE: &str = "operateoperate00";
    const FILM: &str = "filmfilmfilmfilm";

    fn pocket() -> CameraId {
        CameraId::new("pocket").unwrap()
    }

    fn access(most: PageRole) -> PageAccess {
        let tokens = Tokens {
            read: READ.to_owned(),
            operate: OPERATE.to_owned(),
            cameras: BTreeMap::from([(pocket(), FILM.to_owned())]),
        };
        PageAccess::by_token(tokens, most, true)
    }

    fn headers(name: header::HeaderName, value: &str) -> HeaderMap {
        HeaderMap::from_iter([(name, HeaderValue::from_str(value).unwrap())])
    }

    fn someone(n: u32) -> IpAddr {
        Ipv4Addr::from(n).into()
    }

    #[test]
    fn a_token_is_a_role_from_wherever_it_comes() {
        let access = access(PageRole::Operator);
        let now = Instant::now();
        let role = |headers: &HeaderMap| access.role_of(headers, someone(1), now);
        let carried = |token: &str| headers(header::COOKIE, &format!("a=b; sextant_token={token}"));
        let said = |token: &str| headers(header::AUTHORIZATION, &format!("Bearer {token}"));
        for (token, expected) in [
            (READ, Ok(PageRole::Viewer)),
            (OPERATE, Ok(PageRole::Operator)),
            ("wrong", Err(Denied::NoToken)),
            ("", Err(Denied::NoToken)),
        ] {
            assert_eq!(role(&carried(token)), expected);
            assert_eq!(role(&said(token)), expected);
        }
        assert_eq!(role(&HeaderMap::new()), Err(Denied::NoToken));
        assert_eq!(
            PageAccess::open().role_of(&HeaderMap::new(), someone(1), now),
            Ok(PageRole::Operator)
        );
    }

    #[test]
    fn a_cameras_token_is_for_that_camera_alone() {
        let access = access(PageRole::Operator);
        let now = Instant::now();
        let said = |token: &str| headers(header::AUTHORIZATION, &format!("Bearer {token}"));
        let role = access.role_of(&said(FILM), someone(1), now);
        assert_eq!(role, Ok(PageRole::Camera));
        let check = |token: &str, camera: &str| {
            let camera = CameraId::new(camera).unwrap();
            access.check_camera(&said(token), someone(1), &camera, now)
        };
        assert_eq!(check(FILM, "pocket"), Ok(()));
        assert_eq!(check(FILM, "north"), Err(Denied::NotThisCamera));
        assert_eq!(check(OPERATE, "pocket"), Err(Denied::NotThisCamera));
        assert_eq!(check("wrong", "pocket"), Err(Denied::NoToken));
        let open = PageAccess::open();
        let anything = open.check_camera(&HeaderMap::new(), someone(1), &pocket(), now);
        assert_eq!(anything, Ok(()));
    }

    #[test]
    fn nobody_may_do_more_than_the_bridge_itself() {
        let access = access(PageRole::Viewer);
        let role = access.role_of_token(OPERATE, someone(1), Instant::now());
        assert_eq!(role, Ok(PageRole::Viewer));
    }

    #[test]
    fn who_is_wrong_ten_times_in_a_minute_has_to_wait_even_with_the_right_token() {
        let access = access(PageRole::Operator);
        let start = Instant::now();
        let role = |token, n, now| access.role_of_token(token, someone(n), now);
        for _ in 0..MOST_TRIES {
            assert_eq!(role("wrong", 1, start), Err(Denied::NoToken));
        }
        assert_eq!(role(OPERATE, 1, start), Err(Denied::TooManyTries));
        assert_eq!(role(OPERATE, 2, start), Ok(PageRole::Operator));
        let later = start + TRIES_PERIOD;
        assert_eq!(role(OPERATE, 1, later), Ok(PageRole::Operator));
    }

    #[test]
    fn a_flood_of_addresses_ends_at_the_bound() {
        let access = access(PageRole::Operator);
        let now = Instant::now();
        for n in 0..3 * MOST_ADDRESSES as u32 {
            let _ = access.role_of_token("wrong", someone(n), now);
        }
        assert_eq!(access.tries.lock().unwrap().0.len(), MOST_ADDRESSES);
    }

    #[test]
    fn the_cookie_is_out_of_reach_of_scripts_and_of_other_pages() {
        let cookie = access(PageRole::Operator).cookie_of(READ).unwrap();
        let words = cookie.to_str().unwrap();
        for wanted in ["HttpOnly", "SameSite=Strict", "Secure", "Path=/"] {
            assert!(words.contains(wanted), "{words}");
        }
    }

    #[test]
    fn tokens_that_can_be_guessed_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("page-tokens.toml");
        let read = |text: &str| {
            std::fs::write(&file, text).unwrap();
            Tokens::read(&file).map_err(|error| error.to_string())
        };
        let good = format!("read = \"{READ}\"\noperate = \"{OPERATE}\"\n");
        assert!(read(&good).is_ok());
        let words = read(&good.replace(READ, "short")).err().unwrap();
        assert!(words.contains("page-tokens.toml:1:"), "{words}");
        assert!(read(&good.replace(READ, OPERATE)).is_err());
    }
}
