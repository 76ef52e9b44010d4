// An independent check that soft bodies and meshes don't meet within steps: exact tests at moments of the linear motion
// of nodes and vertices.
#ifndef QC_TESTS_BULLET_SOFT_BODY_MOTION_ORACLE_H
#define QC_TESTS_BULLET_SOFT_BODY_MOTION_ORACLE_H

#include "bullet/soft_body/soft_models.h"

/// Remembers where things were, and counts pairs of triangles of different things that penetrate on the way to where
/// they are.
class qcMotionOracle
{
  public:
    static constexpr int s_moments = 16;

    void Add(const btSoftBody* cloth)
    {
        m_things.push_back({cloth, nullptr, nullptr, {}});
        m_things.back().start = m_things.back().Now();
    }

    void Add(const qcMeshShape* shape, const btCollisionObject* object)
    {
        m_things.push_back({nullptr, shape, object, {}});
        m_things.back().start = m_things.back().Now();
    }

    /// The largest count at any moment since the last call, and a new start.
    size_t Count()
    {
        size_t count = 0;
        for (int k = 1; k <= s_moments; k++)
        {
            std::vector<qcSoup> soups;
            for (const Thing& thing : m_things)
                soups.push_back(Between(thing.start, thing.Now(), double(k) / s_moments));
            count = std::max(count, qcCountPenetrating(soups, true));
        }
        for (Thing& thing : m_things)
            thing.start = thing.Now();
        return count;
    }

  private:
    struct Thing
    {
        const btSoftBody* cloth;
        const qcMeshShape* shape;
        const btCollisionObject* object;
        qcSoup start;

        qcSoup Now() const
        {
            return cloth != nullptr ? qcSoupOf(cloth) : qcSoupOf(*shape, object->getWorldTransform());
        }
    };

    static qcSoup Between(const qcSoup& from, qcSoup to, double time)
    {
        for (size_t i = 0; i < to.positions.size(); i++)
            to.positions[i] = (1 - time) * from.positions[i] + time * to.positions[i];
        return to;
    }

    std::vector<Thing> m_things;
};

#endif
