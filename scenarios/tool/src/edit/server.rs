//! Requests of an editor's page, and their responses.

use std::sync::{Arc, Mutex, PoisonError};

use axum::Router;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::Response;
use axum::routing::{get, post};
use coaxle_report::plotting::AXES_JS;
use serde::Deserialize;
use serde_json::{Value, json};

use super::Design;
use super::file::EditedFile;
use super::history::History;
use crate::web::{BASE_CSS, as_json, file, wrong};

/// Parts of a page that differ between editors.
#[derive(Clone, Copy)]
pub(crate) struct PageParts {
    /// The document.
    pub(crate) html: &'static str,
    /// The page's script.
    pub(crate) js: &'static str,
}

struct Editor<D> {
    file: EditedFile,
    history: History,
    design: D,
}

/// Body of a request from the page.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PageRequest {
    /// The page's view settings.
    #[serde(default)]
    asked: Value,
    /// A change of the text, or something else to do.
    #[serde(default)]
    change: Value,
    /// Number of the gesture that the change is part of, such as one drag of the mouse.
    gesture: Option<u64>,
}

type Shared<D> = Arc<Mutex<Editor<D>>>;

pub(super) fn routes<D: Design>(edited: EditedFile, design: D, parts: PageParts) -> Router {
    let text = edited
        .known()
        .map_or_else(|| design.template(), str::to_owned);
    let editor = Editor {
        file: edited,
        history: History::of(text),
        design,
    };
    Router::new()
        .route("/", get(move || file("text/html", parts.html)))
        .route("/base.css", get(|| file("text/css", BASE_CSS)))
        .route(
            "/edit.css",
            get(|| file("text/css", include_str!("edit.css"))),
        )
        .route("/axes.js", get(|| file("text/javascript", AXES_JS)))
        .route(
            "/edit.js",
            get(|| file("text/javascript", include_str!("edit.js"))),
        )
        .route("/page.js", get(move || file("text/javascript", parts.js)))
        .route("/do/{what}", post(handle_request::<D>))
        .with_state(Arc::new(Mutex::new(editor)))
}

async fn handle_request<D: Design>(
    State(editor): State<Shared<D>>,
    Path(what): Path<String>,
    body: String,
) -> Response {
    let request: PageRequest = match serde_json::from_str(&body) {
        Ok(request) => request,
        Err(error) => return wrong(StatusCode::BAD_REQUEST, error.to_string()),
    };
    // Computing takes its time, and so does a node's response.
    let answered = tokio::task::spawn_blocking(move || {
        // A panic of a request leaves a text and its history, which are valid at any time.
        let mut editor = editor.lock().unwrap_or_else(PoisonError::into_inner);
        editor.respond(&what, &request)
    });
    match answered.await {
        Ok(Some(answer)) => as_json(&answer),
        Ok(None) => wrong(
            StatusCode::NOT_FOUND,
            "expected view, change, undo, redo, save or act",
        ),
        Err(error) => wrong(StatusCode::INTERNAL_SERVER_ERROR, error.to_string()),
    }
}

impl<D: Design> Editor<D> {
    fn respond(&mut self, what: &str, request: &PageRequest) -> Option<Value> {
        let done = match what {
            "view" => Ok(None),
            "change" => self.change(request),
            "undo" => {
                self.history.undo();
                Ok(None)
            }
            "redo" => {
                self.history.redo();
                Ok(None)
            }
            "save" => self.save(),
            "act" => self
                .design
                .act(self.history.now(), &request.change)
                .map(Some),
            _ => return None,
        };
        let (refused, told) = match done {
            Ok(told) => (None, told),
            Err(refused) => (Some(refused), None),
        };
        let text = self.history.now();
        Some(json!({
            // Every response has the whole view: the page keeps no state that could differ.
            "view": self.design.view(text, &request.asked),
            "text": text,
            "file": self.file.name(),
            "is_new": self.file.known().is_none(),
            // By content: undoing back to the saved text is saved again.
            "is_saved": self.file.known() == Some(text),
            "can_undo": self.history.can_undo(),
            "can_redo": self.history.can_redo(),
            "refused": refused,
            "told": told,
        }))
    }

    fn change(&mut self, request: &PageRequest) -> Result<Option<String>, String> {
        let text = match request.change.get("text").and_then(Value::as_str) {
            Some(text) => text.to_owned(),
            None => self
                .design
                .changed(self.history.now(), &request.change, &request.asked)?,
        };
        // Checked here, as a text that cannot be saved must not enter the history.
        if text.len() as u64 > D::MOST_BYTES {
            let (received, most) = (text.len(), D::MOST_BYTES);
            return Err(format!(
                "received {received} bytes, expected at most {most}"
            ));
        }
        self.history.change(text, request.gesture);
        Ok(None)
    }

    fn save(&mut self) -> Result<Option<String>, String> {
        let text = self.history.now();
        self.design
            // Texts that make no design may be edited, but not saved over one that does.
            .check(text)
            .map_err(|error| format!("not saved: {error}"))?;
        self.file
            .save(text)
            .map_err(|error| format!("not saved: {error}"))?;
        Ok(Some("saved".to_owned()))
    }
}
