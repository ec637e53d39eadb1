//! The page, inside the program: built from `page/`, committed as `page/dist/`.

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, Response, StatusCode, Uri, header};
use rust_embed::RustEmbed;

#[derive(RustEmbed)]
#[folder = "page/dist/"]
struct Page;

/// Everything comes from the bridge itself; pictures are made in the page.
const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; \
    worker-src 'self'; media-src 'self' blob:; style-src 'self'; img-src 'self' data: blob:; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

/// The file of a path, `index.html` for the root. Files keep their names from version to version, so browsers ask each
/// time and get them only when they changed.
pub(crate) async fn file(uri: Uri, headers: HeaderMap) -> Response<Body> {
    let name = match uri.path().trim_start_matches('/') {
        "" => "index.html",
        name => name,
    };
    match Page::get(name) {
        Some(file) => answer(name, file, &headers),
        None => plain(StatusCode::NOT_FOUND, "no such page\n"),
    }
}

/// The page that makes a browser a camera. Isolated from all other pages: browsers give such a page a clock of 5 us.
pub(crate) async fn camera(headers: HeaderMap) -> Response<Body> {
    let mut response = file(Uri::from_static("/camera.html"), headers).await;
    let set = response.headers_mut();
    for (name, value) in [
        ("cross-origin-opener-policy", "same-origin"),
        ("cross-origin-embedder-policy", "require-corp"),
    ] {
        set.insert(name, HeaderValue::from_static(value));
    }
    response
}

/// A few words as an answer.
pub(crate) fn plain(status: StatusCode, words: &'static str) -> Response<Body> {
    let mut response = Response::new(Body::from(words));
    *response.status_mut() = status;
    let text = HeaderValue::from_static("text/plain; charset=utf-8");
    response.headers_mut().insert(header::CONTENT_TYPE, text);
    response
}

fn answer(name: &str, file: rust_embed::EmbeddedFile, headers: &HeaderMap) -> Response<Body> {
    let tag = entity_tag(&file.metadata.sha256_hash());
    let known = headers
        .get(header::IF_NONE_MATCH)
        .is_some_and(|theirs| theirs.as_bytes() == tag.as_bytes());
    let mut response = Response::new(match known {
        true => Body::empty(),
        false => Body::from(file.data),
    });
    if known {
        *response.status_mut() = StatusCode::NOT_MODIFIED;
    }
    let set = response.headers_mut();
    set.insert(header::CONTENT_TYPE, content_type(name));
    // Workers of an isolated page are to be isolated, too.
    if name.ends_with(".js") {
        let isolated = HeaderValue::from_static("require-corp");
        set.insert("cross-origin-embedder-policy", isolated);
    }
    set.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    set.insert(
        header::CONTENT_SECURITY_POLICY,
        HeaderValue::from_static(CONTENT_SECURITY_POLICY),
    );
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        set.insert(header::ETAG, tag);
    }
    response
}

fn entity_tag(hash: &[u8]) -> String {
    let digits: String = hash[..12]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    format!("\"{digits}\"")
}

fn content_type(name: &str) -> HeaderValue {
    HeaderValue::from_static(match name.rsplit_once('.') {
        Some((_, "html")) => "text/html; charset=utf-8",
        Some((_, "js")) => "text/javascript; charset=utf-8",
        Some((_, "wasm")) => "application/wasm",
        Some((_, "css")) => "text/css; charset=utf-8",
        Some((_, "txt")) => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn get(path: &'static str, headers: &HeaderMap) -> Response<Body> {
        futures_now(file(Uri::from_static(path), headers.clone()))
    }

    fn futures_now<T>(future: impl Future<Output = T>) -> T {
        tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap()
            .block_on(future)
    }

    #[test]
    fn the_page_is_inside_the_program() {
        for path in ["/", "/index.html", "/page.js", "/page.css"] {
            assert_eq!(
                get(path, &HeaderMap::new()).status(),
                StatusCode::OK,
                "{path}"
            );
        }
        let missing = get("/../Cargo.toml", &HeaderMap::new());
        assert_eq!(missing.status(), StatusCode::NOT_FOUND);
    }

    #[test]
    fn an_unchanged_file_is_not_sent_again() {
        let first = get("/page.js", &HeaderMap::new());
        let mut headers = HeaderMap::new();
        headers.insert(header::IF_NONE_MATCH, first.headers()[header::ETAG].clone());
        assert_eq!(get("/page.js", &headers).status(), StatusCode::NOT_MODIFIED);
    }
}
