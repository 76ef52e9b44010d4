// Sides of surfaces that slide on each other: of the vertex and the face, or of the two edges, in place of the closest
// points. Bridson, Fedkiw, Anderson: Robust Treatment of Collisions, Contact and Friction for Cloth Animation, 2002.
#include "soft_body/response/contact_sides.h"

#include <algorithm>
#include <utility>

namespace
{
// Contacts whose offset at the start was within this cosine of their normal are oriented by it alone.
constexpr btScalar s_maxTilt = btScalar(0.7);
// Features have a side of their own if they were this share of the thickness apart along their normal at the start, and
// that is within this cosine of the contact's.
constexpr btScalar s_minHeight = btScalar(0.1), s_minAgreement = btScalar(0.3);
// Features that miss each other by less than this share of their size may have passed.
constexpr btScalar s_crossingSlack = btScalar(0.1);

/// The features of a contact at one time: a vertex and a face, two edges, or neither, where both closest points are
/// corners.
struct ContactFeatures
{
    enum class Kind
    {
        vertexAndFace,
        edges,
        corners
    };
    Kind kind = Kind::corners;
    btVector3 a[3], b[3]; ///< a: of the vertex, the first one, or of an edge; b: of the face or of the other edge

    /// `time`: 0 at the start, 1 at present.
    ContactFeatures(const qcSoftContactView& view, btScalar time)
    {
        const bool isVertexA = view.weightsA[0] == 1.0, isVertexB = view.weightsB[0] == 1.0;
        if (isVertexA != isVertexB)
            kind = Kind::vertexAndFace;
        else if (!isVertexA && view.weightsA[2] == 0.0 && view.weightsB[2] == 0.0)
            kind = Kind::edges;
        for (int i = 0; i < 3; i++)
        {
            a[i] = OfSoft(*view.a, view.verticesA[i], time);
            b[i] = view.b != nullptr ? OfSoft(*view.b, view.verticesB[i], time)
                                     : lerp(view.rigid->StartOf(*view.mesh, view.verticesB[i]),
                                            view.rigid->PresentOf(*view.mesh, view.verticesB[i]), time);
        }
        if (isVertexB && !isVertexA)
            std::swap(a, b);
    }

    static btVector3 OfSoft(const qcSceneSoftBody& soft, uint32_t vertex, btScalar time)
    {
        return lerp(soft.start[vertex], soft.positions[vertex], time);
    }

    /// The normal of the face, or of both edges; zero: there is none.
    btVector3 Normal() const
    {
        btVector3 normal(0, 0, 0);
        if (kind == Kind::vertexAndFace)
            normal = (b[1] - b[0]).cross(b[2] - b[0]);
        else if (kind == Kind::edges)
            normal = (a[1] - a[0]).cross(b[1] - b[0]);
        return normal.length2() > 0 ? normal.normalized() : btVector3(0, 0, 0);
    }

    /// True if the vertex is over the face, or the edges cross, as seen along the normal.
    bool Overlap() const
    {
        const btVector3 between = a[0] - b[0], u = b[1] - b[0];
        const btVector3 v = kind == Kind::edges ? a[0] - a[1] : b[2] - b[0];
        // between = s * u + t * v, up to the normal.
        const btScalar uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), determinant = uu * vv - uv * uv;
        const btScalar s = (between.dot(u) * vv - between.dot(v) * uv) / determinant;
        const btScalar t = (between.dot(v) * uu - between.dot(u) * uv) / determinant;
        return s >= -s_crossingSlack && t >= -s_crossingSlack &&
               (kind == Kind::edges ? std::max(s, t) : s + t) <= 1 + s_crossingSlack;
    }
};
} // namespace

bool qcOrientByFeatures(const qcSoftContactView& view, qcSoftConstraint* constraint)
{
    const btVector3& offset = constraint->startOffset;
    if (view.normal.dot(offset) >= s_maxTilt * offset.length())
        return true;
    const btVector3 start = ContactFeatures(view, 0).Normal();
    const btScalar height = start.dot(offset), agreement = ContactFeatures(view, 1).Normal().dot(view.normal);
    if (btFabs(height) < s_minHeight * view.thickness || btFabs(agreement) < s_minAgreement)
        return true;
    const bool hasPassed = (height > 0) != (agreement > 0);
    const btScalar depth = btFabs(agreement) * view.distance;
    if (hasPassed && !ContactFeatures(view, btFabs(height) / (btFabs(height) + depth)).Overlap())
        return false;
    constraint->normal = hasPassed ? start * (height > 0 ? btScalar(1) : btScalar(-1)) : view.normal;
    constraint->distance = std::min(btFabs(height), view.thickness);
    constraint->missing = view.thickness - constraint->distance;
    return true;
}
