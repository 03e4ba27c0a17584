//! Requests of an editor's page, and their responses.

use std::sync::{Arc, Mutex, PoisonError};

use coaxle_report::plotting::AXES_JS;
use hyper::StatusCode;
use serde::Deserialize;
use serde_json::{Value, json};

use super::Design;
use super::file::EditedFile;
use super::history::History;
use crate::web::{
    BASE_CSS, CSS, HTML, JAVASCRIPT, Response, Routes, Verb, WebRequest, as_json, file, not_found,
    wrong,
};

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

/// The page of an editor.
struct EditorPage<D> {
    editor: Arc<Mutex<Editor<D>>>,
    parts: PageParts,
}

pub(super) fn routes<D: Design>(edited: EditedFile, design: D, parts: PageParts) -> impl Routes {
    let text = edited
        .known()
        .map_or_else(|| design.template(), str::to_owned);
    let editor = Editor {
        file: edited,
        history: History::of(text),
        design,
    };
    EditorPage {
        editor: Arc::new(Mutex::new(editor)),
        parts,
    }
}

impl<D: Design> Routes for EditorPage<D> {
    async fn respond(&self, request: WebRequest) -> Response {
        match (request.verb, request.path().as_slice()) {
            (Verb::Get, [""]) => file(HTML, self.parts.html),
            (Verb::Get, ["base.css"]) => file(CSS, BASE_CSS),
            (Verb::Get, ["edit.css"]) => file(CSS, include_str!("edit.css")),
            (Verb::Get, ["axes.js"]) => file(JAVASCRIPT, AXES_JS),
            (Verb::Get, ["edit.js"]) => file(JAVASCRIPT, include_str!("edit.js")),
            (Verb::Get, ["page.js"]) => file(JAVASCRIPT, self.parts.js),
            (Verb::Post, ["do", what]) => self.act((*what).to_owned(), &request.body).await,
            _ => not_found(),
        }
    }
}

impl<D: Design> EditorPage<D> {
    async fn act(&self, what: String, body: &str) -> Response {
        let request: PageRequest = match serde_json::from_str(body) {
            Ok(request) => request,
            Err(error) => return wrong(StatusCode::BAD_REQUEST, error.to_string()),
        };
        let editor = Arc::clone(&self.editor);
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
