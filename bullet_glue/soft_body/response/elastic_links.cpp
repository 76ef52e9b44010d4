// With the inverse inertia M^-1 = R R' of the joints, unknowns y displace them by R y and have the kinetic energy y'y
// / 2.
#include "soft_body/response/elastic_links.h"

#include <algorithm>

size_t qcElasticLinks::FindOrAdd(btMultiBody* multibody)
{
    auto isIt = [multibody](const Body& body) { return &body.motion->Body() == multibody; };
    auto found = std::find_if(m_bodies.begin(), m_bodies.end(), isIt);
    if (found == m_bodies.end())
    {
        Body added;
        added.motion = std::make_unique<qcMultiBodyMotion>(*multibody, nullptr);
        added.roots = added.motion->FindRoots();
        found = m_bodies.insert(found, std::move(added));
    }
    return size_t(found - m_bodies.begin());
}

int qcElasticLinks::AddPoint(const btMultiBodyLinkCollider& link, const btVector3& arm)
{
    const size_t number = FindOrAdd(link.m_multiBody);
    Body& body = m_bodies[number];
    const auto known = std::find(body.links.begin(), body.links.end(), link.m_link);
    const auto index = size_t(known - body.links.begin());
    if (known == body.links.end())
    {
        body.links.push_back(link.m_link);
        body.motion->AddLink(link.m_link);
    }
    if (!body.motion->CanMove(index))
        return -1;
    Point point{number, std::vector<btMatrix3x3>(size_t(body.ElementCount()), btMatrix3x3(0, 0, 0, 0, 0, 0, 0, 0, 0))};
    for (size_t i = 0; i < body.roots.size(); i++)
    {
        const btVector3 motion = body.motion->DisplacementBy(index, body.roots[i]).At(arm);
        for (int axis = 0; axis < 3; axis++)
            point.motions[i / 3][axis][int(i % 3)] = motion[axis];
    }
    m_points.push_back(std::move(point));
    return int(m_points.size()) - 1;
}

int qcElasticLinks::Number(int first)
{
    for (Body& body : m_bodies)
    {
        body.first = first;
        first += body.ElementCount();
    }
    return first;
}

btVector3 qcElasticLinks::MotionAt(int point, const Vector& x) const
{
    const Point& at = m_points[size_t(point)];
    btVector3 sum(0, 0, 0);
    for (size_t i = 0; i < at.motions.size(); i++)
        sum += at.motions[i] * x[m_bodies[at.body].first + int(i)];
    return sum;
}

void qcElasticLinks::AddForceAt(int point, const btVector3& force, Vector* to) const
{
    const Point& at = m_points[size_t(point)];
    for (size_t i = 0; i < at.motions.size(); i++)
        (*to)[m_bodies[at.body].first + int(i)] += force * at.motions[i];
}

void qcElasticLinks::SetMasses(const Vector& x, Vector* result) const
{
    for (const Body& body : m_bodies)
        for (int i = body.first; i < body.first + body.ElementCount(); i++)
            (*result)[i] = x[i];
}

void qcElasticLinks::AddBlocks(int point, const btMatrix3x3& stiffness, std::vector<btMatrix3x3>* blocks) const
{
    const Point& at = m_points[size_t(point)];
    for (size_t i = 0; i < at.motions.size(); i++)
        (*blocks)[size_t(m_bodies[at.body].first) + i] += at.motions[i].transpose() * stiffness * at.motions[i];
}

void qcElasticLinks::Apply(const Vector& x, btScalar timeStep) const
{
    for (const Body& body : m_bodies)
    {
        qcMultiBodyMotion::Coordinates moved(body.roots.empty() ? 0 : body.roots[0].size(), btScalar(0));
        for (size_t i = 0; i < body.roots.size(); i++)
            for (size_t k = 0; k < moved.size(); k++)
                moved[k] += body.roots[i][k] * x[body.first + int(i / 3)][int(i % 3)];
        body.motion->Push(moved);
        if (body.motion->Commit())
            body.motion->UpdateVelocities(timeStep);
    }
}
