// Each level of branches follows one row of a table: how many, how long, how crooked.
#include "leaves/tree.h"

#include "leaves/random.h"

#include <array>
#include <cmath>

namespace
{
struct Level
{
    int children;             ///< branches of the next level
    btScalar firstChild;      ///< where they begin to grow; 0: base, 1: tip
    btScalar angle;           ///< between them and this level, radians
    btScalar childLength;     ///< share of this level's length
    btScalar taper;           ///< radius at the tip, as a share of that at the base
    btScalar crooked, ascent; ///< change of direction in a segment: at random, and upwards
    int segments, sides;
    btScalar siteSpacing; ///< between leaves, metres; 0: none
};

// Trunk, limbs, branches, twigs.
const std::array<Level, 4> s_levels = {{
    {9, btScalar(0.42), btScalar(0.95), btScalar(0.60), btScalar(0.30), btScalar(0.07), btScalar(0.05), 16, 12, 0},
    {5, btScalar(0.30), btScalar(0.80), btScalar(0.55), btScalar(0.30), btScalar(0.12), btScalar(0.05), 9, 8, 0},
    {4, btScalar(0.25), btScalar(0.75), btScalar(0.60), btScalar(0.35), btScalar(0.15), btScalar(0.03), 6, 6, 0},
    {0, 0, 0, 0, btScalar(0.5), btScalar(0.18), btScalar(-0.03), 4, 5, btScalar(0.05)},
}};

constexpr btScalar s_goldenAngle = btScalar(2.39996);

struct Joint
{
    btVector3 place, along;
    btScalar radius;
};

class Grower
{
  public:
    Grower(uint32_t seed, qcTree* tree) : m_random(seed), m_tree(tree)
    {
    }

    void Grow(size_t level, const Joint& base, btScalar length);

  private:
    std::vector<Joint> Bend(const Level& level, const Joint& base, btScalar length);
    void AddTube(const std::vector<Joint>& joints, int sides);
    void AddSites(const std::vector<Joint>& joints, btScalar length, btScalar spacing);

    qcRandom m_random;
    qcTree* m_tree;
};

btVector3 Perpendicular(const btVector3& direction)
{
    btVector3 p, q;
    btPlaneSpace1(direction, p, q);
    return p;
}

Joint Between(const std::vector<Joint>& joints, btScalar t)
{
    btScalar at = t * btScalar(joints.size() - 1);
    size_t i = btMin(size_t(at), joints.size() - 2);
    btScalar f = at - btScalar(i);
    const Joint &a = joints[i], &b = joints[i + 1];
    return {a.place.lerp(b.place, f), (b.place - a.place).normalized(), a.radius + f * (b.radius - a.radius)};
}

/// The axis of a tube.
std::vector<Joint> Grower::Bend(const Level& level, const Joint& base, btScalar length)
{
    std::vector<Joint> joints = {base};
    Joint joint = base;
    for (int i = 1; i <= level.segments; i++)
    {
        btVector3 jitter(m_random(-1, 1), m_random(-1, 1), m_random(-1, 1));
        joint.along = (joint.along + level.crooked * jitter + btVector3(0, level.ascent, 0)).normalized();
        joint.place += joint.along * (length / btScalar(level.segments));
        btScalar t = btScalar(i) / btScalar(level.segments);
        joint.radius = base.radius * (1 - t * (1 - level.taper));
        joints.push_back(joint);
    }
    return joints;
}

/// Rings around the joints, and a point at each end.
void Grower::AddTube(const std::vector<Joint>& joints, int sides)
{
    std::vector<btVector3>& vertices = m_tree->vertices;
    std::vector<uint32_t>& indices = m_tree->indices;
    auto first = uint32_t(vertices.size()), count = uint32_t(sides);
    btVector3 u = Perpendicular(joints[0].along);
    for (const Joint& joint : joints)
    {
        // Without twist from ring to ring.
        u = (u - joint.along * u.dot(joint.along)).normalized();
        btVector3 v = joint.along.cross(u);
        for (int s = 0; s < sides; s++)
        {
            btScalar angle = SIMD_2_PI * btScalar(s) / btScalar(sides);
            vertices.push_back(joint.place + (u * std::cos(angle) + v * std::sin(angle)) * joint.radius);
        }
    }
    auto bottom = uint32_t(vertices.size()), top = bottom + 1, last = bottom - count;
    vertices.push_back(joints.front().place - joints.front().along * (joints.front().radius * btScalar(0.5)));
    vertices.push_back(joints.back().place + joints.back().along * joints.back().radius);
    for (uint32_t s = 0; s < count; s++)
    {
        uint32_t next = (s + 1) % count;
        for (uint32_t ring = first; ring < last; ring += count)
            indices.insert(indices.end(), {ring + s, ring + next, ring + count + next, //
                                           ring + s, ring + count + next, ring + count + s});
        indices.insert(indices.end(), {bottom, first + next, first + s, top, last + s, last + next});
    }
}

void Grower::AddSites(const std::vector<Joint>& joints, btScalar length, btScalar spacing)
{
    for (btScalar at = spacing; at <= length; at += spacing)
    {
        Joint joint = Between(joints, at / length);
        m_tree->sites.push_back({joint.place, joint.along, joint.radius});
    }
}

void Grower::Grow(size_t levelIndex, const Joint& base, btScalar length)
{
    const Level& level = s_levels[levelIndex];
    std::vector<Joint> joints = Bend(level, base, length);
    if (levelIndex == 0)
        for (Joint& joint : joints) // the roots
            joint.radius *= 1 + btScalar(0.9) * std::exp(-btMax(joint.place.y(), btScalar(0)) / btScalar(0.10));
    AddTube(joints, level.sides);
    if (level.siteSpacing > 0)
        AddSites(joints, length, level.siteSpacing);
    btScalar turn = m_random(0, SIMD_2_PI);
    for (int i = 0; i < level.children; i++)
    {
        btScalar t = level.firstChild + (1 - level.firstChild) * btScalar(i + 1) / btScalar(level.children);
        Joint child = Between(joints, btMin(t + m_random(btScalar(-0.03), btScalar(0.03)), btScalar(0.98)));
        turn += s_goldenAngle + m_random(btScalar(-0.3), btScalar(0.3));
        // The last one goes on where its parent ends.
        btScalar angle =
            i + 1 == level.children ? btScalar(0.25) : level.angle * m_random(btScalar(0.8), btScalar(1.15));
        btVector3 side = Perpendicular(child.along).rotate(child.along, turn);
        child.along = child.along * std::cos(angle) + side * std::sin(angle);
        child.radius *= i + 1 == level.children ? btScalar(0.95) : btScalar(0.65);
        // Branches near the tip are shorter.
        btScalar share =
            level.childLength * (btScalar(1.25) - btScalar(0.6) * t) * m_random(btScalar(0.85), btScalar(1.15));
        Grow(levelIndex + 1, child, length * share);
    }
}
} // namespace

qcTree qcGrowTree(uint32_t seed)
{
    qcTree tree;
    Grower grower(seed, &tree);
    const btScalar below = btScalar(0.08); // of the trunk, in the ground
    grower.Grow(0, {btVector3(0, -below, 0), btVector3(0, 1, 0), btScalar(0.085)}, btScalar(1.9));
    return tree;
}
