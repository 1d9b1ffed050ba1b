//! Tokens to directives: a name and what follows it up to the next name. Follows `Include`.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::directives::is_known;
use super::lexer::{Token, is_no_number, looks_like_number, next_token, number, unquote};
use super::log::{Log, Pos, shown};
use crate::error::{Error, Location};
use crate::file;
use crate::near::no_such_file;

/// Most bytes of scene text, all included files together.
const MAX_TEXT_BYTES: u64 = 64 << 20;
/// Most files open inside each other.
const MAX_INCLUDE_DEPTH: usize = 16;
/// Most `Include` directives followed.
const MAX_INCLUDES: u32 = 1000;

/// A value or a list of values.
#[derive(Debug)]
pub(super) enum Values {
    /// `[]`
    Empty,
    /// Numbers and the byte offset of each.
    Numbers(Vec<f64>, Vec<u32>),
    /// Texts (`true` and `false` count as text, quoted or not) and the byte offset of each.
    Texts(Vec<(String, u32)>),
}

/// One argument of a directive.
#[derive(Debug)]
pub(super) struct Item {
    pub values: Values,
    /// The first token of it.
    pub at: Pos,
    /// A number of it is missing, none or too large (0 stands in its place).
    pub flaw: Option<Error>,
}

/// A directive with everything up to the next one.
#[derive(Debug)]
pub(super) struct Directive {
    pub name: String,
    pub at: Pos,
    pub items: Vec<Item>,
    /// Where its file names are looked up.
    pub folders: Folders,
}

/// Where relative file names are looked up: beside the file that says them, then (as pbrt does)
/// beside the main file.
#[derive(Clone, Debug)]
pub(super) struct Folders {
    own: Option<Arc<Path>>,
    main: Option<Arc<Path>>,
}

impl Folders {
    /// The path of an existing file called `name` at a place in the scene, or a message that says where it was looked for.
    /// Where no file has a name with backslashes in it, they separate folders, as on Windows, where no name has any.
    pub fn find(&self, name: &str, at: Pos, log: &mut Log) -> Result<PathBuf, String> {
        let own_way = std::path::is_separator('\\') && !Path::new(name).is_absolute();
        let why = match self.find_as_written(name, log) {
            Err(why) if name.contains('\\') => why,
            // The same remark as everywhere: the file goes to other machines.
            Ok(_) if name.contains('\\') && own_way => String::new(),
            found => return found,
        };
        let elsewhere = name.replace('\\', "/");
        let path = self.find_as_written(&elsewhere, log).map_err(|_| why)?;
        let message = format!("{} is read as {}, which works on every system", shown(name), shown(&elsewhere));
        log.warn(at, message);
        Ok(path)
    }

    fn find_as_written(&self, name: &str, log: &mut Log) -> Result<PathBuf, String> {
        let (Some(own), Some(main)) = (&self.own, &self.main) else {
            return Err(format!("file {}, but this scene text lies in no folder to look it up in", shown(name)));
        };
        let path = own.join(name);
        // Missing or not: once it is there, it is the one.
        log.add_file(&path);
        if path.exists() {
            return Ok(path);
        }
        let in_main = main.join(name);
        log.add_file(&in_main);
        if in_main.exists() {
            return Ok(in_main);
        }
        let also = if own == main { String::new() } else { format!(", nor beside the main file, {}", main.display()) };
        Err(format!("cannot read {}: {}{also}", shown(name), no_such_file(&path)))
    }
}

struct Frame {
    source: u32,
    text: Arc<str>,
    offset: usize,
    folder: Option<Arc<Path>>,
    /// To recognise cycles.
    canonical: Option<PathBuf>,
}

/// Reads directives one by one. Included files are a stack kept by hand, not recursion.
pub(super) struct Parser {
    frames: Vec<Frame>,
    main_folder: Option<Arc<Path>>,
    bytes_left: u64,
    includes_left: u32,
    end: Pos,
}

impl Parser {
    /// Starts on the main text; `file` is where it came from, if it was a file.
    pub fn new(
        log: &mut Log,
        name: &str,
        text: String,
        folder: Option<Arc<Path>>,
        file: Option<&Path>,
    ) -> Result<Self, Error> {
        if text.len() as u64 > MAX_TEXT_BYTES {
            return Err(Error::file(
                Path::new(name),
                format!("{} bytes of scene text, expected at most {MAX_TEXT_BYTES}", text.len()),
            ));
        }
        let mut parser = Self {
            frames: Vec::new(),
            main_folder: folder.clone(),
            bytes_left: MAX_TEXT_BYTES - text.len() as u64,
            includes_left: MAX_INCLUDES,
            end: Pos { source: 0, offset: text.len() as u32 },
        };
        parser.push(log, name, text, folder, file);
        Ok(parser)
    }

    /// The end of the main text, for messages about what is missing.
    pub fn end(&self) -> Pos {
        self.end
    }

    /// The next directive, `None` at the end. `Include` is dealt with here.
    pub fn next_directive(&mut self, log: &mut Log) -> Result<Option<Directive>, Error> {
        loop {
            let Some((token, at, text)) = self.peek() else {
                self.frames.pop();
                if self.frames.is_empty() {
                    return Ok(None);
                }
                continue;
            };
            if token == Some(Token::Unclosed) {
                return Err(unclosed(at, log));
            }
            if token != Some(Token::Word) || !is_directive_name(&text) {
                let found = shown(&text);
                return Err(log.error(at, format!("found {found}, expected a directive such as Shape or Material")));
            }
            self.advance();
            let mut directive = Directive { name: text, at, items: Vec::new(), folders: self.folders() };
            if directive.name == "ActiveTransform" {
                // The only directive whose argument is a bare name.
                if matches!(self.peek(), Some((Some(Token::Word), ..))) {
                    self.advance();
                }
            }
            while let Some(item) = self.next_item(log)? {
                directive.items.push(item);
            }
            if directive.name != "Include" {
                return Ok(Some(directive));
            }
            // A file that is missing leaves a hole in the scene, no more.
            self.include(&directive, log).or_else(|e| log.leave_out(e, "it is left out"))?;
        }
    }

    fn folders(&self) -> Folders {
        Folders { own: self.frames.last().and_then(|f| f.folder.clone()), main: self.main_folder.clone() }
    }

    fn push(&mut self, log: &mut Log, name: &str, text: String, folder: Option<Arc<Path>>, file: Option<&Path>) {
        let text: Arc<str> = Arc::from(text);
        let source = log.add_source(name, text.clone());
        let canonical = file.and_then(|f| f.canonicalize().ok());
        self.frames.push(Frame { source, text, offset: 0, folder, canonical });
    }

    fn include(&mut self, directive: &Directive, log: &mut Log) -> Result<(), Error> {
        let at = directive.at;
        let name = match directive.items.as_slice() {
            [Item { values: Values::Texts(texts), .. }] if texts.len() == 1 => &texts[0].0,
            _ => return Err(log.error(at, "expected Include and one file name in quotes")),
        };
        let path =
            directive.folders.find(name, at, log).map_err(|message| log.error(at, format!("Include: {message}")))?;
        let canonical = path.canonicalize().ok();
        if canonical.is_some() && self.frames.iter().any(|f| f.canonical == canonical) {
            return Err(log.error(at, format!("Include of {}, which includes this file already", path.display())));
        }
        if self.frames.len() > MAX_INCLUDE_DEPTH {
            return Err(log.error(at, format!("Include inside Include, expected at most {MAX_INCLUDE_DEPTH} deep")));
        }
        if self.includes_left == 0 {
            return Err(log.error(at, format!("one Include too many, expected at most {MAX_INCLUDES}")));
        }
        self.includes_left -= 1;
        let text = read_text(&path, self.bytes_left).map_err(|e| log.error(at, format!("Include: {e}")))?;
        self.bytes_left = self.bytes_left.saturating_sub(text.len() as u64);
        let folder = path.parent().map(Arc::from);
        self.push(log, &path.display().to_string(), text, folder, Some(&path));
        Ok(())
    }

    /// The next token of the innermost file without taking it.
    fn peek(&self) -> Option<(Option<Token>, Pos, String)> {
        let frame = self.frames.last()?;
        let (token, span) = next_token(&frame.text, frame.offset)?;
        let at = Pos { source: frame.source, offset: span.start as u32 };
        Some((token, at, frame.text[span].to_owned()))
    }

    fn advance(&mut self) {
        if let Some(frame) = self.frames.last_mut()
            && let Some((_, span)) = next_token(&frame.text, frame.offset)
        {
            frame.offset = span.end;
        }
    }

    /// The next argument; `None` before the next directive and at the end of the file.
    fn next_item(&mut self, log: &mut Log) -> Result<Option<Item>, Error> {
        let Some(frame) = self.frames.last_mut() else { return Ok(None) };
        let (text, source) = (frame.text.clone(), frame.source);
        let mut values = Values::Empty;
        let mut start: Option<Pos> = None;
        let mut bracketed = false;
        let mut after_comma = false;
        let mut flaw = None;
        loop {
            let Some((token, mut span)) = next_token(&text, frame.offset) else {
                if bracketed && let Some(at) = start {
                    return Err(log.error(at, "'[' without a matching ']'"));
                }
                break;
            };
            let at = Pos { source, offset: span.start as u32 };
            let raw = &text[span.clone()];
            if token == Some(Token::Word) && raw.starts_with(',') {
                if matches!(values, Values::Numbers(..)) && !after_comma {
                    let message = "commas between numbers are read as spaces; pbrt-v3 knows none";
                    log.warn_once(&format!("comma {source}"), at, message);
                } else if flaw.is_none() {
                    flaw = Some(log.error(at, "a comma with no number before it"));
                }
                after_comma = true;
                start.get_or_insert(at);
                frame.offset = span.start + 1;
                continue;
            }
            match token {
                Some(Token::Open) if start.is_none() => bracketed = true,
                Some(Token::Open) if !bracketed => break,
                Some(Token::Close) if bracketed => {
                    frame.offset = span.end;
                    break;
                }
                Some(Token::Quoted) if bracketed || start.is_none() => {
                    if !may_follow_text(&text, span.end) {
                        return Err(unclosed(at, log));
                    }
                    let content = unquote(raw, at, log);
                    push_text(&mut values, content, at, log)?;
                }
                Some(Token::Quoted) => break,
                Some(Token::Word) if looks_like_number(raw) || is_no_number(raw.trim_end_matches(',')) => {
                    // A comma at the end is the next thing to be read.
                    let word = raw.strip_suffix(',').unwrap_or(raw);
                    span.end = span.start + word.len();
                    let value = number(word, at, log)?;
                    if value.is_none() && flaw.is_none() {
                        let most = f32::MAX;
                        let message =
                            format!("number {}, expected a finite one of at most {most:e} in size", shown(word));
                        flaw = Some(log.error(at, message));
                    }
                    push_number(&mut values, value.unwrap_or(0.0), at, log)?;
                    after_comma = false;
                }
                Some(Token::Word) if matches!(raw, "true" | "false") => {
                    if start.is_some() && !bracketed {
                        break;
                    }
                    push_text(&mut values, raw.to_owned(), at, log)?;
                }
                Some(Token::Word) if !bracketed && (start.is_some() || is_directive_name(raw)) => break,
                Some(Token::Unclosed) => return Err(unclosed(at, log)),
                _ if bracketed => {
                    let message = format!("found {}, expected a number, a text in quotes or ']'", shown(raw));
                    return Err(log.error(at, message));
                }
                _ => {
                    let message =
                        format!("found {}, expected a directive, a parameter in quotes or its values", shown(raw));
                    return Err(log.error(at, message));
                }
            }
            start.get_or_insert(at);
            frame.offset = span.end;
            // Without brackets a text is a whole argument; numbers may go on (`LookAt 0 0 5 ...`).
            if !bracketed && matches!(values, Values::Texts(_)) {
                break;
            }
        }
        Ok(start.map(|at| Item { values, at, flaw }))
    }
}

/// A text whose closing quote is missing, which ends at the opening quote of the next one or at the end of the file.
fn unclosed(at: Pos, log: &Log) -> Error {
    let Location { line, column, .. } = log.locate(at);
    log.error(at, format!("the text that begins at {line}:{column} has no closing quote"))
}

/// False if what stands right behind a quote shows that it was not meant to close a text but to open the next one, and
/// so that the text before it was never closed.
fn may_follow_text(text: &str, end: usize) -> bool {
    let Some((Some(Token::Word), span)) = next_token(text, end) else { return true };
    let word = &text[span.clone()];
    let is_value = matches!(word, "true" | "false") || word.trim_end_matches(',').parse::<f64>().is_ok();
    span.start > end || word.starts_with(',') || is_value || is_known(word)
}

/// All directives of pbrt begin with a capital letter, which tells them from stray text.
fn is_directive_name(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_uppercase()) && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn push_number(values: &mut Values, value: f64, at: Pos, log: &Log) -> Result<(), Error> {
    match values {
        Values::Empty => *values = Values::Numbers(vec![value], vec![at.offset]),
        Values::Numbers(numbers, offsets) => {
            numbers.push(value);
            offsets.push(at.offset);
        }
        Values::Texts(_) => return Err(log.error(at, format!("number {value} in a list of texts"))),
    }
    Ok(())
}

fn push_text(values: &mut Values, text: String, at: Pos, log: &Log) -> Result<(), Error> {
    match values {
        Values::Empty => *values = Values::Texts(vec![(text, at.offset)]),
        Values::Texts(texts) => texts.push((text, at.offset)),
        Values::Numbers(..) => return Err(log.error(at, format!("text {} in a list of numbers", shown(&text)))),
    }
    Ok(())
}

/// The text of the main scene file.
pub(super) fn read_scene_text(path: &Path) -> Result<String, Error> {
    read_text(path, MAX_TEXT_BYTES)
}

/// A whole text file of at most `budget` bytes, checked before memory is taken for it.
fn read_text(path: &Path, budget: u64) -> Result<String, Error> {
    let bytes = read_bytes(path, budget)?;
    match bytes.as_slice() {
        [0xff, 0xfe, rest @ ..] => return Ok(utf16(rest, u16::from_le_bytes)),
        [0xfe, 0xff, rest @ ..] => return Ok(utf16(rest, u16::from_be_bytes)),
        _ if bytes.contains(&0) => {
            return Err(Error::file(path, "binary data, expected the text of a pbrt-v3 scene"));
        }
        _ => {}
    }
    // Older editors save Latin-1; what is not UTF-8 there is in comments or becomes an error with a place.
    Ok(String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned()))
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units: Vec<u16> = bytes.chunks_exact(2).map(|b| unit([b[0], b[1]])).collect();
    String::from_utf16_lossy(&units)
}

/// A regular file of at most `budget` bytes.
pub(super) fn read_bytes(path: &Path, budget: u64) -> Result<Vec<u8>, Error> {
    let (file, metadata) = file::open(path, "a file")?;
    if metadata.len() > budget {
        return Err(Error::file(path, format!("{} bytes, expected at most {budget}", metadata.len())));
    }
    let mut bytes = Vec::new();
    // `take`: the file may grow while it is read.
    file.take(budget).read_to_end(&mut bytes).map_err(|e| Error::io(path, "read", e))?;
    Ok(bytes)
}
