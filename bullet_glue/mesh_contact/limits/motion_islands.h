// Islands of objects that would pass each other in a step. An island moves by a common motion, and its objects make a
// part of what their own motions differ from it: they are not stopped in the air.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_MOTION_ISLANDS_H
#define QC_GLUE_MESH_CONTACT_LIMITS_MOTION_ISLANDS_H

#include "common/union_find.h"
#include "mesh_contact/limits/swept_object.h"

#include <set>

class qcMotionIslands
{
  public:
    /// Each object is an island, with all of its own motion.
    void Reset(const std::vector<qcSweptObject*>& objects);
    /// Unites the islands of two objects. One that is not free carries the island of the other; an island with carriers
    /// of different motions is held.
    void Join(const qcSweptObject& a, const qcSweptObject& b);
    /// The island's common motion is none. False: it is held already.
    bool Hold(const qcSweptObject& free);
    /// Sets the common motions and the ends of all objects in islands: the carrier's motion, otherwise the mean
    /// translation by mass.
    void Move();
    /// Slows objects of these numbers down to the common velocity of their island, by the part of the motion that they
    /// have not made, at most by half.
    void Damp(const std::set<uint32_t>& numbers) const;
    /// The object that carries the island, or null.
    const qcSweptObject* CarrierOf(const qcSweptObject& free) const;
    /// True if free objects alone determine the common motion, which has their momentum.
    bool IsFree(const qcSweptObject& free) const;
    /// True if both make the motion of the same carrier and no other: chords of one rigid motion don't meet.
    bool MoveAsOne(const qcSweptObject& a, const qcSweptObject& b) const;

  private:
    struct Island
    {
        const qcSweptObject* carrier = nullptr;
        bool isHeld = false;
        bool isUsed = false; ///< an object in it would pass another one
    };

    std::vector<std::vector<qcSweptObject*>> FindMembers() const;
    void AddCarrier(Island* island, const qcSweptObject* carrier) const;

    std::vector<qcSweptObject*> m_objects;
    mutable qcUnionFind m_sets;    ///< of indices of objects
    std::vector<Island> m_islands; ///< by representative
};

#endif
