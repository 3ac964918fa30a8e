//! Fills the templates, texts with the commands of minijinja: a line with nothing but a command falls away.

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, UndefinedBehavior, Value};

use super::numbers::{number, restitution};
use crate::error::Error;

/// The template with what it names in its places, without a line end.
///
/// Fails where it names what there is not.
pub(super) fn filled(template: &str, values: Value) -> Result<String, Error> {
    const DOING: &str = "fill a template of a simulation code";
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build();
    let mut environment = Environment::new();
    environment.set_syntax(syntax.map_err(Error::internal(DOING))?);
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment.add_filter("number", number);
    environment.add_filter("restitution", restitution);
    let text = environment.render_str(template, values);
    text.map_err(Error::internal(DOING))
}
