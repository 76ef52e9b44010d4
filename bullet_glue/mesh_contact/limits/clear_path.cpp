// A hull that moves past the triangles of meshes at rest. Everything is computed in double, but for the extreme
// vertices of hulls: transforms are taken as they are stored, though their bases are orthogonal only up to rounding.
#include "mesh_contact/limits/clear_path.h"

#include "common/compound_children.h"
#include "common/double_vector.h"
#include "common/shape_triangles.h"
#include "mesh_contact/planes/separating_axis.h"

#include <BulletCollision/CollisionShapes/btTriangleCallback.h>

#include <algorithm>
#include <cmath>

namespace
{
// Upper bounds of the rounding of a few sums and products, as parts of the magnitudes that take part: in Bullet's
// precision, and in double.
constexpr double s_error = 16 * double(SIMD_EPSILON), s_doubleError = 1e-13;
// What takes longer is left to the query, which tests triangles in groups: in products of three numbers, some
// nanoseconds each.
constexpr int s_maxProducts = 1 << 16;
// A triangle takes so many; a plane as many as the hull has vertices, and what it takes to begin with.
constexpr int s_productsOfTriangle = 4, s_productsOfPlane = 32;
// Extreme vertices of larger hulls are found from boxes.
constexpr size_t s_maxRead = 512;

double LengthOf(const qcDoubleVector& v)
{
    return std::sqrt(qcDotOf(v, v));
}

qcDoubleVector Negated(const qcDoubleVector& v)
{
    return {-v[0], -v[1], -v[2]};
}

struct Frame
{
    qcDoubleVector rows[3], origin;

    explicit Frame(const btTransform& transform)
        : rows{qcDoubleVectorOf(transform.getBasis()[0]), qcDoubleVectorOf(transform.getBasis()[1]),
               qcDoubleVectorOf(transform.getBasis()[2])},
          origin(qcDoubleVectorOf(transform.getOrigin()))
    {
    }
    qcDoubleVector Turn(const qcDoubleVector& v) const
    {
        return {qcDotOf(rows[0], v), qcDotOf(rows[1], v), qcDotOf(rows[2], v)};
    }
    /// The vector whose product with any v is that of `direction` with Turn(v).
    qcDoubleVector TurnBack(const qcDoubleVector& direction) const
    {
        qcDoubleVector back;
        for (size_t i = 0; i < 3; i++)
            back[i] = rows[0][i] * direction[0] + rows[1][i] * direction[1] + rows[2][i] * direction[2];
        return back;
    }
    /// Upper bound of the part by which the length of a vector changes when it is turned.
    double Stretch() const
    {
        double deviation = 0;
        for (size_t i = 0; i < 3; i++)
            for (size_t j = 0; j < 3; j++)
                deviation = std::max(deviation, std::abs(qcDotOf(rows[i], rows[j]) - (i == j ? 1 : 0)));
        return 3 * deviation;
    }
};

/// A hull at the start and at the end of the step, and a mesh.
class Path
{
  public:
    Path(const qcSupportMesh& hull, const btTransform& start, const btTransform& end, const btTransform& mesh,
         double extent)
        : m_hull(hull), m_ends{Frame(start), Frame(end)}, m_mesh(mesh), m_extent(extent)
    {
        const double far = LengthOf(m_mesh.origin) + LengthOf(m_ends[0].origin) + LengthOf(m_ends[1].origin);
        m_radius = double(hull.Radius()) * (1 + std::max(m_ends[0].Stretch(), m_ends[1].Stretch()));
        m_error = s_error * (m_radius + far) + s_doubleError * (m_extent + far);
    }

    /// A plane in the mesh's frame: what is below the limit along a direction is below the hull at both ends.
    struct Plane
    {
        qcDoubleVector along;
        double limit;

        bool IsAbove(const qcDoubleVector corners[3]) const
        {
            return qcDotOf(along, corners[0]) < limit && qcDotOf(along, corners[1]) < limit &&
                   qcDotOf(along, corners[2]) < limit;
        }
    };

    /// The highest plane across a direction of about length 1 in the mesh's frame.
    Plane PlaneAcross(const qcDoubleVector& direction) const
    {
        const qcDoubleVector up = m_mesh.Turn(direction), down = Negated(up);
        return {m_mesh.TurnBack(up), -std::max(MaxAt(0, down), MaxAt(1, down)) - qcDotOf(up, m_mesh.origin) - m_error};
    }

    /// True if the middle of the path is above the plane through a point of the mesh.
    bool IsMiddleAbove(const qcDoubleVector& direction, const qcDoubleVector& point) const
    {
        const qcDoubleVector up = m_mesh.Turn(direction);
        return qcDotOf(up, m_ends[0].origin) + qcDotOf(up, m_ends[1].origin) >
               2 * (qcDotOf(up, m_mesh.origin) + qcDotOf(m_mesh.TurnBack(up), point));
    }

    /// A box in the mesh's frame: a triangle outside of it is apart from the path along one of the frame's axes.
    void FindBox(btVector3* lower, btVector3* upper) const
    {
        // A vertex's product with a turned axis is not quite its coordinate.
        const double slack = (m_mesh.Stretch() + s_error) * (m_extent + m_radius);
        for (int axis = 0; axis < 3; axis++)
        {
            qcDoubleVector unit = {0, 0, 0};
            unit[size_t(axis)] = 1;
            const double low = PlaneAcross(unit).limit - slack, high = slack - PlaneAcross(Negated(unit)).limit;
            (*lower)[axis] = btScalar(low - s_error * std::abs(low));
            (*upper)[axis] = btScalar(high + s_error * std::abs(high));
        }
    }

  private:
    double MaxAt(int end, const qcDoubleVector& direction) const
    {
        const qcDoubleVector local = m_ends[end].TurnBack(direction);
        return qcDotOf(direction, m_ends[end].origin) +
               double(m_hull.Max(btVector3(btScalar(local[0]), btScalar(local[1]), btScalar(local[2]))));
    }

    const qcSupportMesh& m_hull;
    const Frame m_ends[2], m_mesh;
    double m_radius; ///< of the hull about its origin, in the world
    double m_extent; ///< of the mesh about its own
    double m_error;  ///< of heights, as of positions in the world that are rounded to btVector3
};

class PathTest : public btTriangleCallback
{
  public:
    /// The hull in the mesh's frame, up to rounding.
    PathTest(const Path& path, const qcPlacedSupport& start, const qcPlacedSupport& end)
        : m_path(path), m_placed{start, end},
          m_productsOfPlane(s_productsOfPlane +
                            2 * int(std::min(size_t(start.mesh->Triangles().pointCount), s_maxRead)))
    {
    }

    void processTriangle(btVector3* triangle, int, int) override
    {
        const qcDoubleVector corners[3] = {qcDoubleVectorOf(triangle[0]), qcDoubleVectorOf(triangle[1]),
                                           qcDoubleVectorOf(triangle[2])};
        m_products += s_productsOfTriangle;
        // Mostly the plane of the triangle before does.
        isClear = isClear && m_products <= s_maxProducts &&
                  (m_plane.IsAbove(corners) || FindOwnPlane(corners) || FindPlaneBetween(triangle, corners));
    }

    bool isClear = true;

  private:
    bool Take(const qcDoubleVector& direction, const qcDoubleVector corners[3])
    {
        m_products += m_productsOfPlane;
        const Path::Plane plane = m_path.PlaneAcross(direction);
        if (!plane.IsAbove(corners))
            return false;
        m_plane = plane;
        return true;
    }

    /// The plane of the triangle.
    bool FindOwnPlane(const qcDoubleVector corners[3])
    {
        const qcDoubleVector cross = qcCrossOf(qcMinus(corners[1], corners[0]), qcMinus(corners[2], corners[0]));
        const double length = LengthOf(cross);
        if (!(length > 0))
            return false;
        const qcDoubleVector normal = {cross[0] / length, cross[1] / length, cross[2] / length};
        return Take(m_path.IsMiddleAbove(normal, corners[0]) ? normal : Negated(normal), corners);
    }

    /// One across the direction from the hull at one end, or half way between these.
    bool FindPlaneBetween(const btVector3 triangle[3], const qcDoubleVector corners[3])
    {
        btVector3 axis(0, 0, 0), sum(0, 0, 0);
        for (const qcPlacedSupport& hull : m_placed)
        {
            const qcSeparation separation = qcSeparateFromTriangle(hull, triangle, axis);
            if (separation.gap <= 0)
                return false;
            axis = separation.axis;
            if (Take(qcDoubleVectorOf(-axis), corners))
                return true;
            sum -= axis;
        }
        return !sum.fuzzyZero() && Take(qcDoubleVectorOf(sum.normalized()), corners);
    }

    const Path& m_path;
    const qcPlacedSupport m_placed[2];
    Path::Plane m_plane{{0, 0, 0}, 0}; ///< above the last triangle; at first above none
    const int m_productsOfPlane;
    int m_products = 0;
};

bool PassesNone(const qcSupportMesh& hull, const btTransform& start, const btTransform& end, const qcMeshShape& mesh,
                const btTransform& place)
{
    btVector3 lower, upper;
    mesh.getAabb(btTransform::getIdentity(), lower, upper);
    const Path path(hull, start, end, place, LengthOf(qcDoubleVectorOf(lower)) + LengthOf(qcDoubleVectorOf(upper)));
    path.FindBox(&lower, &upper);
    PathTest test(path, {&hull, place.inverseTimes(start)}, {&hull, place.inverseTimes(end)});
    mesh.processAllTriangles(&test, lower, upper);
    return test.isClear;
}

/// True if the hull is apart from a core, and not inside, at the start and at the end.
bool PassesCore(const qcSupportMesh& hull, const btTransform& start, const btTransform& end, const qcSupportMesh& core,
                const btTransform& place)
{
    const qcMovedHulls hulls{{&hull, start}, {&core, place}, {&hull, end}, {&core, place}};
    return hulls.AreSeparated(qcSeparateHulls(hulls.startA, hulls.startB, btVector3(0, 0, 0), BT_LARGE_FLOAT));
}

/// The box of a hull's path in the frame of an object at rest. A child whose box does not meet it has a plane below the
/// hull, across one of the frame's axes, at the start and at the end, as a triangle has: see Path::FindBox. The radius
/// of the object counts twice, since the children's places and boxes are rounded in its frame: each by less than
/// s_error of it.
struct ChildBox
{
    btVector3 lower, upper;

    ChildBox(const qcSweptHull& hull, const qcSweptObject& moving, const qcSweptObject& still)
    {
        const double extent = 2 * double(still.children.Radius());
        Path(*hull.mesh, moving.start * hull.local, moving.end * hull.local, still.start, extent)
            .FindBox(&lower, &upper);
    }
};
} // namespace

bool qcHasClearPath(const qcSweptObject& moving, const qcSweptObject& still)
{
    bool isClear = !moving.hulls.empty() && !still.moves;
    auto test = [&](const qcSweptHull& hull, const qcMeshShape& mesh, const btTransform& local)
    {
        isClear = isClear &&
                  PassesNone(*hull.mesh, moving.start * hull.local, moving.end * hull.local, mesh, still.start * local);
    };
    auto testSimple = [&](const btCollisionShape* simple, const btTransform& local)
    {
        const qcMeshShape* mesh = qcAsMeshShape(simple);
        isClear = isClear && mesh != nullptr;
        for (const qcSweptHull& hull : moving.hulls)
            if (isClear)
                test(hull, *mesh, local);
    };
    if (!still.children.AreRead())
    {
        isClear = isClear && still.cores == nullptr;
        if (isClear)
            qcForEachSimpleShape(still.object->getCollisionShape(), btTransform::getIdentity(), testSimple);
        return isClear;
    }
    isClear = isClear && still.children.AreAll();
    for (const qcSweptHull& hull : moving.hulls)
    {
        auto testChild = [&](size_t number)
        {
            const qcSweptChildren::Child& child = still.children[number];
            if (child.core == nullptr)
                test(hull, *child.mesh, child.local);
            else
                isClear = isClear && PassesCore(*hull.mesh, moving.start * hull.local, moving.end * hull.local,
                                                *child.core, still.start * child.local);
        };
        if (!isClear)
            break;
        const ChildBox box(hull, moving, still);
        still.children.VisitBox(box.lower, box.upper, testChild);
    }
    return isClear;
}
