// A peer library for tests: it finds nothing, refuses all bodies, or fails at the first step.
#include "bench/peers/library.h"

enum
{
    method_blind,
    method_refuses,
    method_fails
};

static const qcPeerMethod s_methods[] = {{"blind", true}, {"refuses", true}, {"fails", false}};

static uint32_t s_opened[] = {method_blind, method_refuses, method_fails};

static void* Open(const qcPeerTask* task, uint32_t method, const qcPeerPose* poses)
{
    (void)task;
    (void)poses;
    return method == method_refuses ? NULL : &s_opened[method];
}

static bool Step(void* state, const qcPeerPose* poses, qcPeerAnswer* answer)
{
    (void)poses;
    *answer = (qcPeerAnswer){NULL, 0};
    return *(uint32_t*)state != method_fails;
}

static void Close(void* state)
{
    (void)state;
}

__attribute__((visibility("default"))) const qcPeerLibrary* qcPeer_GetLibrary(void);

const qcPeerLibrary* qcPeer_GetLibrary(void)
{
    static const qcPeerLibrary library = {"Liar 1", s_methods, 3, Open, Step, Close};
    return &library;
}
