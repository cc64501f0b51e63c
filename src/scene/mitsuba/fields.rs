//! What is asked of an object: its properties by name and type, and the objects within. What nobody
//! asks for is refused in the end.

use std::cell::RefCell;

use glam::{DAffine3, DVec3};

use super::bsdfs::BLEND;
use super::tree::{Child, NAME, Object, Property, Tag, Target, Tree, Value};
use crate::math::Fault;
use crate::math::text::excerpt;
use crate::scene::error::{Findings, SceneError};

/// An object that is asked.
pub struct Fields<'a> {
    pub tree: &'a Tree,
    pub object: &'a Object,
    /// How many blends it is within.
    pub blends: usize,
    /// The names that have been asked for.
    asked: RefCell<Vec<String>>,
    /// The children that have been asked for, by number.
    taken: RefCell<Vec<usize>>,
}

/// A property, or an object in its place.
#[derive(Clone, Copy, Debug)]
pub enum Given<'a> {
    Property(&'a Property),
    Object(usize),
}

impl<'a> Fields<'a> {
    /// Of the object of a number.
    pub fn of(tree: &'a Tree, index: usize) -> Self {
        let object = &tree.objects[index];
        Self { tree, object, blends: 0, asked: RefCell::default(), taken: RefCell::default() }
    }

    /// Of an object within this one.
    pub fn within(&self, index: usize) -> Self {
        let blends = self.blends + usize::from(self.object.plugin == BLEND);
        Self { blends, ..Self::of(self.tree, index) }
    }

    /// How errors and reports call the object.
    pub fn label(&self) -> String {
        self.object.label()
    }

    /// The error that something is wrong with a property, where it stands.
    pub fn wrong(
        &self,
        name: &str,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        let property = self.object.properties.iter().find(|property| property.name == name);
        let child = self.object.children.iter().find(|child| child.name == name);
        let spot = property.map(|it| &it.spot).or_else(|| child.map(|it| &it.spot));
        let spot = spot.unwrap_or(&self.object.spot);
        let own = Object { spot: spot.clone(), ..self.object.clone() };
        SceneError::new(format!("{}, {}", own.label(), excerpt(name, NAME)), problem, remedy)
    }

    /// The error that something is wrong with the object.
    pub fn refuse(&self, problem: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::new(self.label(), problem, remedy)
    }

    /// The error that a fault is, whose fields are called as the properties are, or by other names.
    pub fn fault(&self, fault: Fault, names: &[(&str, &str)]) -> SceneError {
        let Fault { field, problem, remedy } = fault;
        let renamed = names.iter().find(|(own, _)| *own == field).map(|(_, name)| *name);
        match renamed.unwrap_or(&field) {
            "" => self.refuse(problem, remedy),
            name => self.wrong(name, problem, remedy),
        }
    }

    /// A property.
    pub fn property(&self, name: &str) -> Option<&'a Property> {
        self.asked.borrow_mut().push(name.to_owned());
        self.object.properties.iter().find(|property| property.name == name)
    }

    /// Whether it has a property or an object of this name.
    pub fn has(&self, name: &str) -> bool {
        let mut children = self.object.children.iter();
        self.object.properties.iter().any(|property| property.name == name)
            || children.any(|child| child.name == name)
    }

    /// A property, or an object of this name.
    pub fn given(&self, name: &str) -> Option<Given<'a>> {
        let property = self.property(name).map(Given::Property);
        property.or_else(|| {
            let mut children = self.object.children.iter().enumerate();
            let (number, child) = children.find(|(_, child)| child.name == name)?;
            self.taken.borrow_mut().push(number);
            object_of(child).map(Given::Object)
        })
    }

    /// Takes notice of properties that change nothing here.
    pub fn ignore(&self, names: &[&str]) {
        self.asked.borrow_mut().extend(names.iter().map(|name| (*name).to_owned()));
    }

    /// All objects within of a kind: their names and numbers.
    pub fn objects(&self, tag: Tag) -> Vec<(&'a str, usize)> {
        let mut found = Vec::new();
        for (number, child) in self.object.children.iter().enumerate() {
            let Some(object) = object_of(child) else { continue };
            if self.tree.objects[object].tag == tag {
                self.taken.borrow_mut().push(number);
                found.push((child.name.as_str(), object));
            }
        }
        found
    }

    /// The only object within of a kind, if there is one.
    pub fn only(&self, tag: Tag) -> Result<Option<usize>, SceneError> {
        match self.objects(tag)[..] {
            [] => Ok(None),
            [(_, only)] => Ok(Some(only)),
            [_, (_, second), ..] => {
                let problem = format!("is one {} too many", tag.name());
                Err(SceneError::new(self.tree.objects[second].label(), problem, "keep one"))
            }
        }
    }

    /// A number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, SceneError> {
        match self.property(name).map(|property| &property.value) {
            None => Ok(None),
            Some(Value::Float(value)) => Ok(Some(*value)),
            Some(Value::Integer(value)) => Ok(Some(*value as f64)),
            Some(other) => Err(self.of_kind(name, other, "a float")),
        }
    }

    /// A whole number that is not negative.
    pub fn count(&self, name: &str) -> Result<Option<u32>, SceneError> {
        let Some(value) = self.integer(name)? else { return Ok(None) };
        let count = u32::try_from(value);
        count.map(Some).map_err(|_| self.wrong(name, format!("{value} is out of range"), ""))
    }

    /// A whole number.
    pub fn integer(&self, name: &str) -> Result<Option<i64>, SceneError> {
        match self.property(name).map(|property| &property.value) {
            None => Ok(None),
            Some(Value::Integer(value)) => Ok(Some(*value)),
            Some(other) => Err(self.of_kind(name, other, "an integer")),
        }
    }

    /// Yes or no.
    pub fn boolean(&self, name: &str) -> Result<Option<bool>, SceneError> {
        match self.property(name).map(|property| &property.value) {
            None => Ok(None),
            Some(Value::Boolean(value)) => Ok(Some(*value)),
            Some(other) => Err(self.of_kind(name, other, "a boolean")),
        }
    }

    /// Words.
    pub fn text(&self, name: &str) -> Result<Option<&'a str>, SceneError> {
        match self.property(name).map(|property| &property.value) {
            None => Ok(None),
            Some(Value::Text(value)) => Ok(Some(value)),
            Some(other) => Err(self.of_kind(name, other, "a string")),
        }
    }

    /// A vector or a point.
    pub fn vector(&self, name: &str) -> Result<Option<DVec3>, SceneError> {
        match self.property(name).map(|property| &property.value) {
            None => Ok(None),
            Some(Value::Vector(value)) => Ok(Some(*value)),
            Some(other) => Err(self.of_kind(name, other, "a point")),
        }
    }

    /// A transform; none is the identity.
    pub fn transform(&self, name: &str) -> Result<DAffine3, SceneError> {
        match self.property(name).map(|property| &property.value) {
            None => Ok(DAffine3::IDENTITY),
            Some(Value::Transform(value)) => Ok(*value),
            Some(other) => Err(self.of_kind(name, other, "a transform")),
        }
    }

    /// The error that a property is of the wrong kind.
    pub fn of_kind(&self, name: &str, value: &Value, wanted: &str) -> SceneError {
        let problem = format!("is of kind {}, and must be {wanted}", value.kind());
        self.wrong(name, problem, "")
    }

    /// Refuses properties and objects that nobody has asked for: they would be without effect.
    pub fn finish(&self) -> Result<(), SceneError> {
        let mut findings = Findings::default();
        let asked = self.asked.borrow();
        for Property { name, .. } in &self.object.properties {
            if !asked.contains(name) {
                let mut known: Vec<&str> = asked.iter().map(String::as_str).collect();
                known.sort_unstable();
                known.dedup();
                let remedy = match known.is_empty() {
                    true => "it has none".to_owned(),
                    false => format!("it has {}", known.join(", ")),
                };
                let error = self.wrong(name, "is no property of it that is known", remedy);
                findings.note::<()>(Err(error));
            }
        }
        for (number, child) in self.object.children.iter().enumerate() {
            let Some(object) = object_of(child) else { continue };
            if !self.taken.borrow().contains(&number) {
                let inner = self.tree.objects[object].label();
                let problem = format!("has no place for `{}`: {inner}", excerpt(&child.name, NAME));
                findings.note::<()>(Err(self.refuse(problem, "remove it")));
            }
        }
        findings.result()
    }
}

/// The object that a child is, after references have been resolved.
pub fn object_of(child: &Child) -> Option<usize> {
    match child.target {
        Target::Object(object) => Some(object),
        Target::Id(_) => None,
    }
}
