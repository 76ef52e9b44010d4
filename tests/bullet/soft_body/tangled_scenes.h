// Scenes of soft bodies that penetrate at the start, at rest in a world without gravity unless a scene has it.
#ifndef QC_TESTS_BULLET_SOFT_BODY_TANGLED_SCENES_H
#define QC_TESTS_BULLET_SOFT_BODY_TANGLED_SCENES_H

#include "bullet/soft_body/soft_world.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <cmath>

struct qcTangledWorld : qcSoftWorld
{
    explicit qcTangledWorld(btScalar gravity = 0)
    {
        SetGravity(btVector3(0, -gravity, 0));
    }

    /// A rectangle of `n` by `m` nodes in the plane y = 0.
    btSoftBody* AddCloth(btScalar halfX, btScalar halfZ, int n, int m)
    {
        btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-halfX, 0, -halfZ),
                                                           btVector3(halfX, 0, -halfZ), btVector3(-halfX, 0, halfZ),
                                                           btVector3(halfX, 0, halfZ), n, m, 0, true);
        cloth->setTotalMass(1);
        return AddThin(cloth);
    }

    btSoftBody* AddBall(const btVector3& center, btScalar radius, int nodes)
    {
        btSoftBody* ball =
            btSoftBodyHelpers::CreateEllipsoid(world.getWorldInfo(), center, btVector3(radius, radius, radius), nodes);
        ball->generateBendingConstraints(2);
        ball->setTotalMass(1, true);
        return AddThin(ball);
    }

    void Step()
    {
        world.stepSimulation(btScalar(1.0 / 60), 0);
    }

    /// The largest speed of a node.
    btScalar MaxSpeed() const
    {
        btScalar max = 0;
        for (const btSoftBody* cloth : cloths)
            for (int i = 0; i < cloth->m_nodes.size(); i++)
                max = btMax(max, cloth->m_nodes[i].m_v.length());
        return max;
    }

    btScalar Energy() const
    {
        btScalar sum = 0;
        for (const btSoftBody* cloth : cloths)
            for (int i = 0; i < cloth->m_nodes.size(); i++)
                if (cloth->m_nodes[i].m_im > 0)
                    sum += cloth->m_nodes[i].m_v.length2() / cloth->m_nodes[i].m_im / 2;
        return sum;
    }
};

/// Places each node at function(its place in the plane); its velocity is zero.
template <typename Function> void qcPlaceNodes(btSoftBody* cloth, Function function)
{
    for (int i = 0; i < cloth->m_nodes.size(); i++)
    {
        btSoftBody::Node& node = cloth->m_nodes[i];
        node.m_x = node.m_q = function(node.m_x);
        node.m_v.setZero();
    }
    cloth->updateBounds();
    cloth->updateNormals();
}

inline void qcTurn(btSoftBody* body, const btVector3& axis, btScalar angle, const btVector3& to)
{
    body->transform(btTransform(btQuaternion(axis, angle), to));
}

/// Two cloths that cross at right angles; the upright one is below the other by two fifths.
inline void qcMakeCrossed(qcTangledWorld* world)
{
    world->AddCloth(1, 1, 40, 40);
    btSoftBody* upright = world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    qcTurn(upright, btVector3(1, 0, 0), SIMD_HALF_PI, btVector3(btScalar(0.03), btScalar(0.113), btScalar(0.017)));
}

/// A strip whose end goes through the strip itself, after three quarters of a turn.
inline void qcMakeThroughItself(qcTangledWorld* world)
{
    btSoftBody* cloth = world->AddCloth(btScalar(1.2), btScalar(0.3), 61, 16);
    const btScalar radius = btScalar(0.25), turn = btScalar(1.5) * SIMD_PI;
    qcPlaceNodes(cloth,
                 [=](const btVector3& at)
                 {
                     // Along x to 0, a circle upwards and back, then downwards through the plane of the start.
                     btScalar s = at.x() + btScalar(0.3), arc = s / radius, z = at.z();
                     if (s <= 0)
                         return btVector3(s, 0, z);
                     if (arc <= turn)
                         return btVector3(radius * btSin(arc), radius * (1 - btCos(arc)), z);
                     return btVector3(-radius, radius - (s - radius * turn), z);
                 });
}

/// An upright cloth through an open sheet; two fifths are below.
inline void qcMakeThroughSheet(qcTangledWorld* world)
{
    world->AddMesh(qcFloorModel(4, 7), 0, btVector3(0, 0, 0));
    btSoftBody* upright = world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    qcTurn(upright, btVector3(1, 0, 0), SIMD_HALF_PI, btVector3(btScalar(0.03), btScalar(0.113), btScalar(0.017)));
}

/// A level cloth through a box, whose upper end sticks out in the middle.
inline void qcMakeThroughBox(qcTangledWorld* world)
{
    world->AddMesh(qcBoxModel(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 3), 0,
                   btVector3(btScalar(0.01), btScalar(-0.1), btScalar(0.02)));
    world->AddCloth(btScalar(0.6), btScalar(0.6), 25, 25);
}

/// A level cloth around a thin upright pole, whose upper end sticks out.
inline void qcMakeThroughPole(qcTangledWorld* world)
{
    world->AddMesh(qcBoxModel(btVector3(btScalar(0.03), btScalar(0.5), btScalar(0.03)), 4), 0,
                   btVector3(btScalar(0.013), btScalar(-0.4), btScalar(0.02)));
    world->AddCloth(btScalar(0.6), btScalar(0.6), 25, 25);
}

/// A cloth one corner of which is below another one.
inline void qcMakeCorner(qcTangledWorld* world)
{
    world->AddCloth(1, 1, 40, 40);
    btSoftBody* cloth = world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    qcPlaceNodes(cloth, [](const btVector3& at)
                 { return btVector3(at.x(), btScalar(0.15) * (at.x() + at.z()) + btScalar(0.08), at.z()); });
}

/// A cloth one corner of which is below a static sheet.
inline void qcMakeCornerBelowSheet(qcTangledWorld* world)
{
    world->AddMesh(qcFloorModel(4, 7), 0, btVector3(0, 0, 0));
    btSoftBody* cloth = world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    qcPlaceNodes(cloth, [](const btVector3& at)
                 { return btVector3(at.x(), btScalar(0.15) * (at.x() + at.z()) + btScalar(0.08), at.z()); });
}

/// Two balls, one half inside of the other.
inline void qcMakeBalls(qcTangledWorld* world)
{
    world->AddBall(btVector3(0, 0, 0), btScalar(0.5), 400);
    world->AddBall(btVector3(btScalar(0.5), btScalar(0.1), btScalar(0.05)), btScalar(0.5), 300);
}

/// Two equal cloths at one place.
inline void qcMakeCoincident(qcTangledWorld* world)
{
    world->AddCloth(btScalar(0.5), btScalar(0.5), 16, 16);
    world->AddCloth(btScalar(0.5), btScalar(0.5), 16, 16);
}

/// Two cloths that cross at right angles along a row of nodes, whose positions they share exactly.
inline void qcMakeCrossedAtNodes(qcTangledWorld* world)
{
    world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    btSoftBody* upright = world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    qcPlaceNodes(upright, [](const btVector3& at) { return btVector3(at.x(), at.z(), 0); });
}

/// Two cloths at right angles that touch along a rim, exactly.
inline void qcMakeTouching(qcTangledWorld* world)
{
    world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    btSoftBody* upright = world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    qcPlaceNodes(upright, [](const btVector3& at) { return btVector3(at.x(), at.z() + btScalar(0.5), 0); });
}

/// They touch up to the rounding of a rotation.
inline void qcMakeNearlyTouching(qcTangledWorld* world)
{
    world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    btSoftBody* upright = world->AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
    qcTurn(upright, btVector3(1, 0, 0), SIMD_HALF_PI, btVector3(0, btScalar(0.5), 0));
}

/// A strip that was wrung and crumpled without self-collision.
inline void qcMakeWrung(qcTangledWorld* world)
{
    btSoftBody* cloth = world->AddCloth(btScalar(0.6), btScalar(0.3), 49, 25);
    qcPlaceNodes(cloth,
                 [](const btVector3& at)
                 {
                     btScalar turn = 3 * SIMD_PI * at.x(), squeeze = btScalar(0.45), z = at.z();
                     btScalar width = btScalar(0.09) * btSin(9 * z) + btScalar(0.02) * btSin(23 * at.x() + 5 * z);
                     btScalar height = btScalar(0.07) * btSin(17 * z + 3 * at.x());
                     return btVector3(squeeze * at.x() + btScalar(0.05) * btSin(14 * z),
                                      width * btSin(turn) + height * btCos(turn),
                                      width * btCos(turn) - height * btSin(turn));
                 });
}

/// A strip folded on itself, whose upper rim is below the lower layer.
inline void qcMakeFolded(qcTangledWorld* world)
{
    btSoftBody* cloth = world->AddCloth(btScalar(0.8), btScalar(0.3), 49, 19);
    const btScalar radius = btScalar(0.08), turn = btScalar(1.12) * SIMD_PI;
    qcPlaceNodes(cloth,
                 [=](const btVector3& at)
                 {
                     btScalar s = at.x(), arc = btMin(s / radius, turn), z = at.z();
                     if (s <= 0)
                         return btVector3(s, 0, z);
                     btScalar straight = btMax(btScalar(0), s - radius * turn);
                     return btVector3(radius * btSin(arc) + straight * btCos(arc),
                                      radius * (1 - btCos(arc)) + straight * btSin(arc), z);
                 });
}

struct qcTangledSceneDef
{
    const char* name;
    void (*make)(qcTangledWorld*);
    btScalar gravity;
    int steps; ///< after which at most `left` pairs are tangled
    size_t left;
    double speed; ///< bound of the nodes' speed, where there is no gravity
};

/// Scenes with penetrating triangles.
const qcTangledSceneDef qcTangledScenes[] = {
    {"crossed cloths", qcMakeCrossed, 0, 120, 0, 1},
    {"crossed cloths that fall", qcMakeCrossed, 10, 120, 0, 1},
    {"strip through itself", qcMakeThroughItself, 0, 120, 0, 1},
    {"cloth through a sheet", qcMakeThroughSheet, 0, 120, 0, 1},
    {"cloth through a sheet, with gravity", qcMakeThroughSheet, 10, 120, 0, 1},
    {"cloth through a box", qcMakeThroughBox, 0, 120, 0, 1},
    {"cloth through a box, with gravity", qcMakeThroughBox, 10, 120, 0, 1},
    {"cloth through a pole", qcMakeThroughPole, 0, 120, 0, 1},
    {"corner", qcMakeCorner, 0, 120, 0, 1},
    {"corner below a sheet, with gravity", qcMakeCornerBelowSheet, 10, 120, 0, 1},
    {"balls", qcMakeBalls, 0, 120, 0, 1},
    {"coincident cloths", qcMakeCoincident, 0, 120, 0, 1},
    {"wrung strip", qcMakeWrung, 0, 300, 34, 2.5},
    {"folded strip", qcMakeFolded, 0, 120, 0, 1},
};

#endif
