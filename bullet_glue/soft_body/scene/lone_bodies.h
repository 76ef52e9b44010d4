// Soft bodies that touch nothing in a step, themselves included, as their boxes show: no query has to test them. Proof:
// plugin/docs/proofs/lone_bodies.md.
#ifndef QC_GLUE_SOFT_BODY_SCENE_LONE_BODIES_H
#define QC_GLUE_SOFT_BODY_SCENE_LONE_BODIES_H

#include "common/object_key.h"

#include <cstddef>
#include <vector>

/// Boxes of bodies over a step, to find those that overlap no other.
class qcMotionBoxes
{
  public:
    void Clear()
    {
        m_boxes.clear();
    }
    /// `needsPartner`: two boxes with this flag are not compared.
    void Add(const btVector3& lower, const btVector3& upper, bool needsPartner);
    /// Finds the boxes that overlap another one. O(n log n) where few of them overlap along the axis on which they are
    /// spread most; O(n) if the boxes are those of the last call.
    void Find();
    /// True if the box that was added as number `i` overlaps another one. Valid after Find.
    bool Overlaps(size_t i) const
    {
        return m_overlaps[i] != 0;
    }

  private:
    struct Box
    {
        btVector3 lower, upper;
        bool needsPartner;

        bool operator==(const Box& other) const
        {
            return qcAreSame(lower, other.lower) && qcAreSame(upper, other.upper) && needsPartner == other.needsPartner;
        }
    };

    int FindAxis() const;

    std::vector<Box> m_boxes;      ///< by number
    std::vector<Box> m_foundBoxes; ///< of the last Find
    std::vector<size_t> m_order;   ///< numbers along the axis
    std::vector<char> m_overlaps;  ///< by number, of the last Find
};

/// True if the nodes, each linked to the next one, are a chain that runs along one direction: no two links without a
/// common node are within `distance` at the end, nor meet in the motion from start to end. O(nodes).
bool qcIsStretchedChain(const std::vector<btVector3>& start, const std::vector<btVector3>& end, btScalar distance);

/// Enlarges a box by `reach` and by what the sums of its coordinates are rounded by.
void qcEnlarge(btScalar reach, btVector3 box[2]);

/// The box around the motion of nodes, enlarged by `reach`. False: a node is not finite, or there is none. O(nodes).
bool qcFindMotionBox(const std::vector<btVector3>& start, const std::vector<btVector3>& end, btScalar reach,
                     btVector3 box[2]);

#endif
