//! The list of contacts, sorted by their shapes, and of what later stages ask of them.
//!
//! Contacts that lose their points stay for some steps (`room.rs`): most of them get points again. What has none makes no
//! difference to anything.

use crate::collision::link::Link;
use crate::collision::manifold::Contact;
use crate::collision::pair::append;
use crate::collision::room::{self, Room};

/// Contacts, and the link of each at the same place.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactList {
    pub contacts: Vec<Contact>,
    pub links: Vec<Link>,
}

impl ContactList {
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.links.clear();
    }

    pub fn push(&mut self, contact: Contact, link: Link) {
        self.contacts.push(contact);
        self.links.push(link);
    }

    /// Puts the contacts of another list behind those of this one.
    pub fn append(&mut self, more: &mut Self) {
        append(&mut self.contacts, &mut more.contacts);
        append(&mut self.links, &mut more.links);
    }

    /// Puts new ones in, of whose pairs none is there; so many of the old ones are without points.
    pub fn insert(&mut self, mut new: Self, empty: usize) {
        let len = self.contacts.len();
        if room::is_full_of_gone(empty, len) {
            self.drop_empty();
        } else if room::are_few(new.contacts.len(), len) {
            for index in 0..new.contacts.len() {
                if let Some(place) = self.room_for(new.contacts[index].key()) {
                    self.exchange(place, &mut new, index);
                }
            }
            new.drop_empty();
        }
        self.merge(new);
    }

    /// Only those with points stay.
    #[inline(never)]
    fn drop_empty(&mut self) {
        self.contacts.retain(|contact| !contact.is_empty());
        self.links.retain(|link| link.manifolds > 0);
    }

    fn room_for(&mut self, key: (u32, u32)) -> Option<usize> {
        let Self { contacts, links } = self;
        let place = contacts.partition_point(|other| other.key() < key);
        let room = Room::near(place, links.len(), |at| links[at].manifolds == 0)?;
        room.make(links);
        Some(room.make(contacts))
    }

    fn exchange(&mut self, place: usize, other: &mut Self, place_there: usize) {
        std::mem::swap(&mut self.contacts[place], &mut other.contacts[place_there]);
        std::mem::swap(&mut self.links[place], &mut other.links[place_there]);
    }

    fn merge(&mut self, mut new: Self) {
        let Some(first) = new.contacts.first() else { return };
        let mut rest = self.contacts.len();
        if self.contacts.last().is_none_or(|last| last.key() < first.key()) {
            return self.append(&mut new);
        }
        // Contacts are large: from the back they move at most once, changing places with the new ones at the end.
        self.contacts.resize_with(rest + new.contacts.len(), || Contact::new((0, 0), (0, 0), false));
        self.links.extend_from_slice(&new.links);
        for left in (0..new.contacts.len()).rev() {
            let (key, end) = (new.contacts[left].key(), rest);
            while rest > 0 && self.contacts[rest - 1].key() > key {
                self.contacts.swap(rest + left, rest - 1);
                rest -= 1;
            }
            self.links.copy_within(rest..end, rest + left + 1);
            self.exchange(rest + left, &mut new, left);
        }
    }
}

/// Keeps some of the contacts, and the links at the same places.
pub(crate) fn retain(contacts: &mut Vec<Contact>, links: &mut Vec<Link>, mut keeps: impl FnMut(&Contact) -> bool) {
    if links.len() != contacts.len() {
        links.clear();
    }
    let (mut place, mut kept) = (0, 0);
    contacts.retain(|contact| {
        let keep = keeps(contact);
        if keep && kept < links.len() {
            links[kept] = links[place];
            kept += 1;
        }
        place += 1;
        keep
    });
    links.truncate(kept);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::BodyState;
    use crate::collision::link::Judge;
    use crate::{Body, Shape, Vec3, WorldOptions};

    fn item(key: u32, has_points: bool) -> (Contact, Link) {
        let body = Body::dynamic(Shape::ball(0.5));
        let body = BodyState::new(&body, &body.flat_shapes()).unwrap();
        let mut contact = Contact::new((key, key + 1), (key, key), false);
        if has_points {
            contact.manifolds.push(crate::collision::manifold::Manifold {
                normal: Vec3::Y,
                points: Default::default(),
                part: 0,
                lambda_torsion: 0.0,
                lambda_rolling: [0.0; 2],
            });
        }
        let link = Link::new(&contact, &body, &body, &Judge::new(&WorldOptions::default(), 0.01));
        (contact, link)
    }

    /// All ways to deal six keys to what was there, with and without points, and what is new.
    #[test]
    fn lists_stay_sorted_and_side_by_side() {
        for dealt in 0..3_u32.pow(6) {
            let digit = |key: u32| dealt / 3_u32.pow(key) % 3;
            let list = |items: &mut dyn Iterator<Item = (u32, bool)>| {
                let mut list = ContactList::default();
                for (key, has_points) in items {
                    let (contact, link) = item(key, has_points);
                    list.push(contact, link);
                }
                list
            };
            let mut old = list(&mut (0..6).filter(|&key| digit(key) < 2).map(|key| (key, digit(key) == 0)));
            // Enough others behind that the few new ones look for room nearby in some of the cases.
            let others = if dealt % 2 == 0 { 10..530 } else { 10..20 };
            old.append(&mut list(&mut others.clone().map(|key| (key, true))));
            let new = list(&mut (0..6).filter(|&key| digit(key) == 2).map(|key| (key, true)));
            let empty = old.contacts.iter().filter(|contact| contact.is_empty()).count();
            old.insert(new, empty);
            let ContactList { contacts, links } = old;
            let with_points = contacts.iter().filter(|contact| !contact.is_empty()).map(|contact| contact.shape_a);
            assert!(with_points.eq((0..6).filter(|&key| digit(key) != 1).chain(others)), "{dealt}");
            assert!(contacts.is_sorted_by_key(Contact::key), "{dealt}");
            assert_eq!(contacts.len(), links.len());
            for (contact, link) in contacts.iter().zip(&links) {
                assert_eq!(
                    (contact.body_a, contact.manifolds.len() as u32),
                    (link.bodies[0], link.manifolds),
                    "{dealt}"
                );
            }
        }
    }
}
